/* The machine of the loop "vud_lathe ours.pd fig11a_step_m50", simulated: everything but its controller.
 * Exported code belongs to whoever exported it. The parts that come from Leadscrew (the ls_ functions and the machine
 * layer) are under the BSD 3-clause licence; the README beside this file has its text. */
#include "pd_plant.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: it changes the results"
#endif
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "this target computes with more digits than a double has; on 32-bit x86 compile with -msse2 -mfpmath=sse"
#endif

/* A step in the unit of the loop's command. */
typedef struct StepParams {
    double initial; /* command before the step */
    double target; /* command after the step */
    double time; /* when the command steps, to the nearest period, s */
} StepParams;

/* The size of a count. */
typedef struct GratingCountParams {
    double resolution_mm; /* length of one count: pitch over subdivision, mm */
} GratingCountParams;

/* The gains as the step reads them. */
typedef struct DutyPD {
    double kp;
    double t_d;
    double kept; /* Share of the filtered derivative that stays over a period. */
} DutyPD;

/* The exact step over one period: new = sum(new_from_old old) + new_from_drive drive. */
typedef struct LatheServoHold {
    double full_duty_speed;
    double pwm_from_pwm;
    double current_from_pwm;
    double current_from_current;
    double speed_from_pwm;
    double speed_from_current;
    double speed_from_speed;
    double position_from_pwm;
    double position_from_current;
    double position_from_speed;
    double reading_from_pwm;
    double reading_from_current;
    double reading_from_speed;
    double reading_from_position;
    double reading_from_reading;
    double pwm_from_drive;
    double current_from_drive;
    double speed_from_drive;
    double position_from_drive;
    double reading_from_drive;
} LatheServoHold;

/* The band; the wider of the two counts. */
typedef struct SettlingParams {
    double percent; /* half width of the band in percent of the last move, % */
    double band; /* half width of the band in the unit of the error */
} SettlingParams;

/* The part of a run that a metric looks at. */
typedef struct Window {
    double from_time; /* samples before this time are left out, s */
} Window;

typedef struct MetricParams {
    SettlingParams settling_1pct;
    SettlingParams settling_2um;
    Window overshoot;
    Window error_after_2s;
    Window rms_error;
    Window chatter;
} MetricParams;

/* What a loop needs to know of time, chance and limits. */
typedef struct Clock {
    double period_;
    double step;
    int64_t substeps;
    int64_t seed;
    double bound;
} Clock;

typedef struct LoopParams {
    StepParams reference;
    double disturbance;
    double output_disturbance;
    GratingCountParams sensor;
    DutyPD controller;
    double actuator;
    LatheServoHold plant;
    MetricParams metrics;
    Clock clock;
} LoopParams;

/* The last error and the filtered derivative. */
typedef struct DutyPDState {
    double error; /* mm */
    double derivative; /* mm/s */
    double rho; /* duty */
    double started; /* 0 before the first period, then 1 */
} DutyPDState;

/* The chain's lagged speeds, the slide's true position and what the grating shows of it. */
typedef struct LatheServoState {
    double pwm; /* mm/s */
    double current; /* mm/s */
    double speed; /* mm/s */
    double position; /* mm */
    double reading; /* mm */
} LatheServoState;

/* When the last move ended and since when the error has been inside the band. */
typedef struct SettlingState {
    double start;
    double entered;
    double inside;
    double origin;
    double last_command;
    double moving;
    double seen;
} SettlingState;

/* The last move's direction and the excess since its last change of command. */
typedef struct OvershootState {
    double excess;
    double direction;
    double last_command;
    double seen;
} OvershootState;

/* The largest value in the window so far; negative before the first sample. */
typedef struct Peak {
    double largest;
} Peak;

/* An integral over the window and the window's length so far. */
typedef struct Sum {
    double total;
    double time;
} Sum;

/* Squared differences of the output from period to period. */
typedef struct Differences {
    double total;
    double periods_;
    double last;
    double seen;
} Differences;

typedef struct MetricStates {
    SettlingState settling_1pct;
    SettlingState settling_2um;
    OvershootState overshoot;
    Peak error_after_2s;
    Sum rms_error;
    Differences chatter;
} MetricStates;

typedef struct LoopState {
    double reference;
    double disturbance;
    double output_disturbance;
    double sensor;
    DutyPDState controller;
    double actuator;
    LatheServoState plant;
    double integrator;
    double sent;
    double seen;
    MetricStates metrics;
} LoopState;

/* What a block receives as noise: which numbers are its own in this period. */
typedef struct Noise {
    int64_t seed;
    int64_t run;
    int64_t block;
    int64_t period_;
} Noise;

typedef struct tuple2 {
    double v0;
    double v1;
} tuple2;

/* What the axis shows: where the slide is, and the lagged value that a grating reader counts. */
typedef struct LathePosition {
    double position;
    double reading;
} LathePosition;

typedef struct LoopState_ {
    LoopState v0;
    double v1;
    double v2;
    LathePosition v3;
    double v4;
} LoopState_;

typedef struct LoopState_and_value {
    LoopState next;
    double value;
} LoopState_and_value;

typedef struct LatheServoState_and_value {
    LatheServoState next;
    double value;
} LatheServoState_and_value;

/* The double whose 64 bits are these. */
static inline double bits_to_float(int64_t bits)
{
    double x;

    memcpy(&x, &bits, sizeof x);
    return x;
}

/* The 64 bits of a double as an integer. */
static inline int64_t float_to_bits(double x)
{
    int64_t bits;

    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* What follows in a range: its end where the sum would have more than 64 bits. */
static inline int64_t range_next(int64_t at, int64_t by, int64_t end)
{
    const uint64_t left = by > 0 ? (uint64_t)end - (uint64_t)at : (uint64_t)at - (uint64_t)end;

    return left > (by > 0 ? (uint64_t)by : 0 - (uint64_t)by) ? at + by : end;
}

static LoopParams ls_params_of(const double *P, int64_t P_size0, const double *A, int64_t A_size0)
{
    (void)P_size0;
    (void)A_size0;
    (void)A;
    return (LoopParams){.reference = (StepParams){.initial = P[0], .target = P[1], .time = P[2]}, .disturbance = 0.0,
        .output_disturbance = 0.0, .sensor = (GratingCountParams){.resolution_mm = P[5]},
        .controller = (DutyPD){.kp = P[6], .t_d = P[7], .kept = P[8]}, .actuator = 0.0,
        .plant = (LatheServoHold){.full_duty_speed = P[10], .pwm_from_pwm = P[11], .current_from_pwm = P[12],
        .current_from_current = P[13], .speed_from_pwm = P[14], .speed_from_current = P[15],
        .speed_from_speed = P[16], .position_from_pwm = P[17], .position_from_current = P[18],
        .position_from_speed = P[19], .reading_from_pwm = P[20], .reading_from_current = P[21],
        .reading_from_speed = P[22], .reading_from_position = P[23], .reading_from_reading = P[24],
        .pwm_from_drive = P[25], .current_from_drive = P[26], .speed_from_drive = P[27],
        .position_from_drive = P[28], .reading_from_drive = P[29]},
        .metrics = (MetricParams){.settling_1pct = (SettlingParams){.percent = P[30], .band = P[31]},
        .settling_2um = (SettlingParams){.percent = P[32], .band = P[33]}, .overshoot = (Window){.from_time = P[34]},
        .error_after_2s = (Window){.from_time = P[35]}, .rms_error = (Window){.from_time = P[36]},
        .chatter = (Window){.from_time = P[37]}}, .clock = (Clock){.period_ = P[38], .step = P[39],
        .substeps = (int64_t)P[40], .seed = (int64_t)P[41], .bound = P[42]}};
}

static LoopState ls_state_of(const double *S, int64_t S_size0, const double *B, int64_t B_size0)
{
    (void)S_size0;
    (void)B_size0;
    (void)B;
    return (LoopState){.reference = 0.0, .disturbance = 0.0, .output_disturbance = 0.0, .sensor = 0.0,
        .controller = (DutyPDState){.error = S[4], .derivative = S[5], .rho = S[6], .started = S[7]},
        .actuator = 0.0, .plant = (LatheServoState){.pwm = S[9], .current = S[10], .speed = S[11], .position = S[12],
        .reading = S[13]}, .integrator = S[14], .sent = 0.0, .seen = 0.0,
        .metrics = (MetricStates){.settling_1pct = (SettlingState){.start = S[17], .entered = S[18], .inside = S[19],
        .origin = S[20], .last_command = S[21], .moving = S[22], .seen = S[23]},
        .settling_2um = (SettlingState){.start = S[24], .entered = S[25], .inside = S[26], .origin = S[27],
        .last_command = S[28], .moving = S[29], .seen = S[30]}, .overshoot = (OvershootState){.excess = S[31],
        .direction = S[32], .last_command = S[33], .seen = S[34]}, .error_after_2s = (Peak){.largest = S[35]},
        .rms_error = (Sum){.total = S[36], .time = S[37]}, .chatter = (Differences){.total = S[38],
        .periods_ = S[39], .last = S[40], .seen = S[41]}}};
}

/* target from the sample nearest to time on, initial before.
 * step.py:19 */
static double step(StepParams p, double t, double dt)
{
    return t > p.time - 0.5 * dt ? p.target : p.initial;
}

static tuple2 ls_reference_2(StepParams p, double s, double t, double dt, Noise noise)
{
    (void)noise;
    (void)s;
    return (tuple2){0.0, step(p, t, dt)};
}

static tuple2 ls_disturbance_2(double p, double s, double t, double dt, Noise noise)
{
    (void)noise;
    (void)dt;
    (void)t;
    (void)s;
    (void)p;
    return (tuple2){0.0, 0.0};
}

static tuple2 ls_output_disturbance_2(double p, double s, double t, double dt, Noise noise)
{
    (void)noise;
    (void)dt;
    (void)t;
    (void)s;
    (void)p;
    return (tuple2){0.0, 0.0};
}

/* True position and lagged reading.
 * lathe_servo.py:107 */
static LathePosition show(LatheServoHold p, LatheServoState s)
{
    (void)p;
    return (LathePosition){.position = s.position, .reading = s.reading};
}

static LathePosition ls_plant_output(LatheServoHold p, LatheServoState s)
{
    return show(p, s);
}

static LathePosition ls_disturbed(LathePosition actual, double offset)
{
    (void)offset;
    return actual;
}

static LathePosition ls_seen(double line, LathePosition actual, int64_t k, int64_t substeps)
{
    (void)substeps;
    (void)k;
    (void)line;
    return actual;
}

/* Size of x: clears the sign bit, also of -0.0 and NaN. Exact. */
static double ls_fabs(double x)
{
    return bits_to_float(float_to_bits(x) & INT64_C(9223372036854775807));
}

/* The nearest integer as a float, the even one of two; keeps -0.0, infinities and NaN. Exact. */
static double ls_round_half_even(double x)
{
    const double size = ls_fabs(x);
    double nearest = size + 4503599627370496.0 - 4503599627370496.0;
    nearest = size < 4503599627370496.0 ? nearest : size;
    return float_to_bits(x) < 0 ? -nearest : nearest;
}

/* The largest integer not above x, as a float; keeps -0.0, infinities and NaN. Exact. */
static double ls_floor(double x)
{
    const double nearest = ls_round_half_even(x);
    return nearest > x ? nearest - 1.0 : nearest;
}

/* The reading as a whole number of counts.
 * grating_count.py:23 */
static double grating_count(GratingCountParams p, LathePosition actual)
{
    return p.resolution_mm * ls_floor(actual.reading / p.resolution_mm + 0.5);
}

static tuple2 ls_sensor_2(GratingCountParams p, double s, LathePosition actual, double t, double dt, Noise noise)
{
    (void)noise;
    (void)dt;
    (void)t;
    (void)s;
    return (tuple2){0.0, grating_count(p, actual)};
}

/* The first half of a period: the loop's state with reference, disturbances and sensor moved on, and what they say.
 *
 * Returns:
 *     state, command, feedback, true output, load. */
static LoopState_ sense(LoopParams p, LoopState s, double t, int64_t k, int64_t run)
{
    const double dt = p.clock.period_;
    const int64_t seed = p.clock.seed;
    const tuple2 t1 = ls_reference_2(p.reference, s.reference, t, dt, (Noise){.seed = seed, .run = run, .block = 0,
        .period_ = k});
    const double reference = t1.v0;
    const double command = t1.v1;
    const tuple2 t2 = ls_disturbance_2(p.disturbance, s.disturbance, t, dt, (Noise){.seed = seed, .run = run,
        .block = 1, .period_ = k});
    const double disturbance = t2.v0;
    const double load = t2.v1;
    const tuple2 t3 = ls_output_disturbance_2(p.output_disturbance, s.output_disturbance, t, dt,
        (Noise){.seed = seed, .run = run, .block = 2, .period_ = k});
    const double output_disturbance = t3.v0;
    const double offset = t3.v1;
    LathePosition shown = ls_plant_output(p.plant, s.plant);
    LathePosition actual = ls_disturbed(shown, offset);
    LathePosition measured = ls_disturbed(ls_seen(s.seen, shown, k, p.clock.substeps), offset);
    const tuple2 t4 = ls_sensor_2(p.sensor, s.sensor, measured, t, dt, (Noise){.seed = seed, .run = run, .block = 3,
        .period_ = k});
    const double sensor = t4.v0;
    const double feedback = t4.v1;
    LoopState state = (LoopState){.reference = reference, .disturbance = disturbance,
        .output_disturbance = output_disturbance, .sensor = sensor, .controller = s.controller,
        .actuator = s.actuator, .plant = s.plant, .integrator = s.integrator, .sent = s.sent, .seen = s.seen,
        .metrics = s.metrics};
    return (LoopState_){state, command, feedback, actual, load};
}

static int64_t ls_keep_sensed(double *X, int64_t X_size0, double command, double feedback, double load)
{
    (void)X_size0;
    X[0] = command;
    X[1] = feedback;
    X[2] = load;
    return 0;
}

static int64_t ls_keep_state(double *S, int64_t S_size0, LoopState s)
{
    (void)S_size0;
    S[4] = 1.0 * s.controller.error;
    S[5] = 1.0 * s.controller.derivative;
    S[6] = 1.0 * s.controller.rho;
    S[7] = 1.0 * s.controller.started;
    S[9] = 1.0 * s.plant.pwm;
    S[10] = 1.0 * s.plant.current;
    S[11] = 1.0 * s.plant.speed;
    S[12] = 1.0 * s.plant.position;
    S[13] = 1.0 * s.plant.reading;
    S[14] = 1.0 * s.integrator;
    S[17] = 1.0 * s.metrics.settling_1pct.start;
    S[18] = 1.0 * s.metrics.settling_1pct.entered;
    S[19] = 1.0 * s.metrics.settling_1pct.inside;
    S[20] = 1.0 * s.metrics.settling_1pct.origin;
    S[21] = 1.0 * s.metrics.settling_1pct.last_command;
    S[22] = 1.0 * s.metrics.settling_1pct.moving;
    S[23] = 1.0 * s.metrics.settling_1pct.seen;
    S[24] = 1.0 * s.metrics.settling_2um.start;
    S[25] = 1.0 * s.metrics.settling_2um.entered;
    S[26] = 1.0 * s.metrics.settling_2um.inside;
    S[27] = 1.0 * s.metrics.settling_2um.origin;
    S[28] = 1.0 * s.metrics.settling_2um.last_command;
    S[29] = 1.0 * s.metrics.settling_2um.moving;
    S[30] = 1.0 * s.metrics.settling_2um.seen;
    S[31] = 1.0 * s.metrics.overshoot.excess;
    S[32] = 1.0 * s.metrics.overshoot.direction;
    S[33] = 1.0 * s.metrics.overshoot.last_command;
    S[34] = 1.0 * s.metrics.overshoot.seen;
    S[35] = 1.0 * s.metrics.error_after_2s.largest;
    S[36] = 1.0 * s.metrics.rms_error.total;
    S[37] = 1.0 * s.metrics.rms_error.time;
    S[38] = 1.0 * s.metrics.chatter.total;
    S[39] = 1.0 * s.metrics.chatter.periods_;
    S[40] = 1.0 * s.metrics.chatter.last;
    S[41] = 1.0 * s.metrics.chatter.seen;
    return 0;
}

static double ls_given_output(const double *X, int64_t X_size0)
{
    (void)X_size0;
    return X[3];
}

static tuple2 ls_actuator_2(double p, double s, double output, double t, double dt)
{
    (void)dt;
    (void)t;
    (void)s;
    (void)p;
    return (tuple2){0.0, output};
}

static int64_t ls_send(double line, double applied, int64_t k)
{
    (void)k;
    (void)applied;
    (void)line;
    return 0;
}

/* The second half: the loop's state with the actuator moved on, and what goes to the plant. */
static LoopState_and_value act(LoopParams p, LoopState s, double output, double t, int64_t k)
{
    const tuple2 t1 = ls_actuator_2(p.actuator, s.actuator, output, t, p.clock.period_);
    const double actuator = t1.v0;
    const double applied = t1.v1;
    ls_send(s.sent, applied, k);
    LoopState state = (LoopState){.reference = s.reference, .disturbance = s.disturbance,
        .output_disturbance = s.output_disturbance, .sensor = s.sensor, .controller = s.controller,
        .actuator = actuator, .plant = s.plant, .integrator = s.integrator, .sent = s.sent, .seen = s.seen,
        .metrics = s.metrics};
    return (LoopState_and_value){state, applied};
}

static double ls_given_load(const double *X, int64_t X_size0)
{
    (void)X_size0;
    return X[2];
}

static double ls_sent(double line, double applied, int64_t k, int64_t j, int64_t substeps)
{
    (void)substeps;
    (void)j;
    (void)k;
    (void)line;
    return applied;
}

/* b if b > a else a: of equals, and where one is NaN, the first. */
static double ls_maximum(double a, double b)
{
    return b > a ? b : a;
}

/* b if b < a else a: of equals, and where one is NaN, the first. */
static double ls_minimum(double a, double b)
{
    return b < a ? b : a;
}

/* Zero in place of a value that has decayed to nothing: denormal numbers are slow.
 * lathe_servo.py:112 */
static double flushed(double x)
{
    return fabs(x) > 1e-30 ? x : 0.0;
}

/* State one period later under the constant duty u.
 * lathe_servo.py:117 */
static LatheServoState lathe_servo(LatheServoHold p, LatheServoState s, double u, double dt)
{
    (void)dt;
    const double drive = -p.full_duty_speed * ls_minimum(1.0, ls_maximum(-1.0, u));
    const double pwm = p.pwm_from_pwm * s.pwm + p.pwm_from_drive * drive;
    const double current = p.current_from_pwm * s.pwm + p.current_from_current * s.current + p.current_from_drive
        * drive;
    const double speed = p.speed_from_pwm * s.pwm + p.speed_from_current * s.current + p.speed_from_speed * s.speed
        + p.speed_from_drive * drive;
    const double position = p.position_from_pwm * s.pwm + p.position_from_current * s.current
        + p.position_from_speed * s.speed + s.position + p.position_from_drive * drive;
    const double reading = p.reading_from_pwm * s.pwm + p.reading_from_current * s.current + p.reading_from_speed
        * s.speed + p.reading_from_position * s.position + p.reading_from_reading * s.reading
        + p.reading_from_drive * drive;
    return (LatheServoState){.pwm = flushed(pwm), .current = flushed(current), .speed = flushed(speed),
        .position = position, .reading = flushed(reading)};
}

static LatheServoState_and_value ls_plant_step(LatheServoHold p, LatheServoState s, double memory, double u, double load, double t, double dt)
{
    (void)t;
    (void)load;
    return (LatheServoState_and_value){lathe_servo(p, s, u, dt), memory};
}

/* 0.0 where |x| < 1e-300, else x: a decaying state never turns denormal, which is 19 times slower. */
static double ls_flush(double x)
{
    return ls_fabs(x) < 1e-300 ? 0.0 : x;
}

static LatheServoState ls_settled_2(LatheServoState plant)
{
    return (LatheServoState){.pwm = ls_flush(plant.pwm), .current = ls_flush(plant.current),
        .speed = ls_flush(plant.speed), .position = ls_flush(plant.position), .reading = ls_flush(plant.reading)};
}

static int64_t ls_watch(double line, LatheServoHold p, LatheServoState plant, int64_t n)
{
    (void)n;
    (void)plant;
    (void)p;
    (void)line;
    return 0;
}

/* The loop's state after the plant has moved through period k. */
static LoopState hold(LoopParams p, LoopState s, double applied, double load, int64_t k)
{
    LatheServoState plant = s.plant;
    double memory = s.integrator;
    const double step_ = p.clock.step;
    const int64_t substeps = p.clock.substeps;
    const int64_t end1 = substeps;
    for (int64_t j = 0; j < end1; j++) {
        const double u = ls_sent(s.sent, applied, k, j, substeps);
        const LatheServoState_and_value t2 = ls_plant_step(p.plant, plant, memory, u, load,
            k * p.clock.period_ + j * step_, step_);
        plant = t2.next;
        memory = t2.value;
        ls_watch(s.seen, p.plant, plant, k * substeps + j + 1);
    }
    return (LoopState){.reference = s.reference, .disturbance = s.disturbance,
        .output_disturbance = s.output_disturbance, .sensor = s.sensor, .controller = s.controller,
        .actuator = s.actuator, .plant = ls_settled_2(plant), .integrator = memory, .sent = s.sent, .seen = s.seen,
        .metrics = s.metrics};
}

static int64_t read_period(double *restrict P, int64_t P_size0, double *restrict A, int64_t A_size0,
    double *restrict S, int64_t S_size0, double *restrict B, int64_t B_size0, double *restrict X, int64_t X_size0,
    int64_t *restrict counters, int64_t counters_size0)
{
    (void)counters_size0;
    LoopParams p = ls_params_of(P, P_size0, A, A_size0);
    const LoopState_ t1 = sense(p, ls_state_of(S, S_size0, B, B_size0), counters[0] * p.clock.period_, counters[0],
        0);
    LoopState s = t1.v0;
    const double command = t1.v1;
    const double feedback = t1.v2;
    LathePosition v = t1.v3;
    (void)v;
    const double load = t1.v4;
    ls_keep_sensed(X, X_size0, command, feedback, load);
    ls_keep_state(S, S_size0, s);
    return 0;
}

static int64_t write_period(double *restrict P, int64_t P_size0, double *restrict A, int64_t A_size0,
    double *restrict S, int64_t S_size0, double *restrict B, int64_t B_size0, double *restrict X, int64_t X_size0,
    int64_t *restrict counters, int64_t counters_size0)
{
    (void)counters_size0;
    LoopParams p = ls_params_of(P, P_size0, A, A_size0);
    const int64_t k = counters[0];
    const LoopState_and_value t1 = act(p, ls_state_of(S, S_size0, B, B_size0), ls_given_output(X, X_size0),
        k * p.clock.period_, k);
    LoopState s = t1.next;
    const double applied = t1.value;
    ls_keep_state(S, S_size0, hold(p, s, applied, ls_given_load(X, X_size0), k));
    counters[0] = k + 1;
    return 0;
}

void pd_plant_init(pd_plant *m)
{
    static const pd_plant start = {
        .P = {0.0, -50.0, 0.0, 0.0, 0.0, 0.000625, 0.2505263157894737, 0.0154, 0.16232061118184818, 0.0, 289.0, 0.28650479686019004, 0.25932836819703076, 0.513417119032592, 0.01045372430083579, 0.04156026046667254, 0.942873143854875, 4.090297102093402e-06, 2.3349893517678805e-05, 0.0009711565544671262, 1.8065534877625981e-07, 1.3161392172847723e-06, 7.734521498034384e-05, 0.15351827510938593, 0.846481724890614, 0.71349520313981, 0.22725451277037723, 0.005112871377616752, 1.4032549131015135e-06, 4.833979727956532e-08, 1.0, 0.0, 0.0, 0.002, 0.0, 2.0, 0.0, 2.0, 0.001, 0.001, 1.0, 0.0, 1.7976931348623157e+308},
        .A = {0.0},
        .S = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
        .B = {0.0},
        .X = {0},
        .counters = {0},
    };

    *m = start;
}

void pd_plant_read(pd_plant *m)
{
    read_period(m->P, 43, m->A, 1, m->S, 42, m->B, 1, m->X, 4, m->counters, 2);
}

void pd_plant_write(pd_plant *m)
{
    write_period(m->P, 43, m->A, 1, m->S, 42, m->B, 1, m->X, 4, m->counters, 2);
}
