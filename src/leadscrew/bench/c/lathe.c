/* Two forms of the plant, three powers (portable, with a shortcut at 0, libm's): six loops. Compile with -ffp-contract=off. */
#include "lathe.h"
#include "portable.h"

static inline double clipped(double x, double low, double high)
{
    return x > high ? high : x > low ? x : low;
}

static inline double flushed(double x) { return fabs(x) > 1e-30 ? x : 0.0; }

static inline double settled(double x) { return fabs(x) < 1e-300 ? 0.0 : x; }

static inline int interval(const double *centres, double x)
{
    int i = 0;
    for (int c = 1; c < 5; c++)
        i += x >= centres[c];
    return i;
}

/* product, height: of 36 rules the four around the point fire */
static inline double infer(const Lathe *p, double x, double y)
{
    const double *c = p->centres;
    x = clipped(x, c[0], c[5]);
    y = clipped(y, c[0], c[5]);
    int i = interval(c, x), j = interval(c, y);
    double mu = (x - c[i]) * p->reciprocal_widths[i], nu = (y - c[j]) * p->reciprocal_widths[j];
    const double *t = p->rules + 6 * i + j;
    double lower = (1.0 - nu) * t[0] + nu * t[1], upper = (1.0 - nu) * t[6] + nu * t[7];
    return (1.0 - mu) * lower + mu * upper;
}

static inline void hold_step(const Lathe *p, Axis *s, double duty)
{
    double drive = -p->full_duty_speed * clipped(duty, -1.0, 1.0);
    const double *a = p->a, *b = p->b;
    Axis o = *s;
    s->pwm = flushed(a[0] * o.pwm + b[0] * drive);
    s->current = flushed(a[1] * o.pwm + a[2] * o.current + b[1] * drive);
    s->speed = flushed(a[3] * o.pwm + a[4] * o.current + a[5] * o.speed + b[2] * drive);
    s->position = a[6] * o.pwm + a[7] * o.current + a[8] * o.speed + o.position + b[3] * drive;
    s->reading = flushed(a[9] * o.pwm + a[10] * o.current + a[11] * o.speed + a[12] * o.position + a[13] * o.reading
        + b[4] * drive);
}

static inline Axis rates(const Lathe *p, const Axis *s, double drive)
{
    Axis k = { (drive - s->pwm) / p->pwm_lag, (s->pwm - s->current) / p->electrical_lag,
        (s->current - s->speed) / p->mechanical_lag, s->speed, (s->position - s->reading) / p->grating_lag };
    return k;
}

static inline Axis along(const Axis *s, double h, const Axis *k)
{
    Axis x = { s->pwm + h * k->pwm, s->current + h * k->current, s->speed + h * k->speed,
        s->position + h * k->position, s->reading + h * k->reading };
    return x;
}

static inline void rk4_step(const Lathe *p, Axis *s, double duty)
{
    double drive = -p->full_duty_speed * clipped(duty, -1.0, 1.0), step = p->period / p->substeps, half = 0.5 * step;
    for (int j = 0; j < (int)p->substeps; j++) {
        Axis x, k1 = rates(p, s, drive), k2, k3, k4, sum;
        x = along(s, half, &k1);
        k2 = rates(p, &x, drive);
        x = along(s, half, &k2);
        k3 = rates(p, &x, drive);
        x = along(s, step, &k3);
        k4 = rates(p, &x, drive);
        sum.pwm = k1.pwm + 2.0 * k2.pwm + 2.0 * k3.pwm + k4.pwm;
        sum.current = k1.current + 2.0 * k2.current + 2.0 * k3.current + k4.current;
        sum.speed = k1.speed + 2.0 * k2.speed + 2.0 * k3.speed + k4.speed;
        sum.position = k1.position + 2.0 * k2.position + 2.0 * k3.position + k4.position;
        sum.reading = k1.reading + 2.0 * k2.reading + 2.0 * k3.reading + k4.reading;
        *s = along(s, step / 6.0, &sum);
    }
    s->pwm = settled(s->pwm);
    s->current = settled(s->current);
    s->speed = settled(s->speed);
    s->position = settled(s->position);
    s->reading = settled(s->reading);
}

/* returns the number of periods done: fewer than asked for where the loop diverged */
#define LOOP(NAME, POW, STEP)                                                                                          \
    long NAME(const Lathe *p, Motion *m, long periods)                                                                 \
    {                                                                                                                  \
        Motion s = *m;                                                                                                 \
        double dt = p->period;                                                                                         \
        for (long k = 0; k < periods; k++) {                                                                           \
            double feedback = p->resolution * portable_floor(s.axis.reading / p->resolution + 0.5);                    \
            double e = (p->target - feedback) / p->error_scale;                                                        \
            double change = (e - s.e) * p->error_scale * (p->rate_interval / dt);                                      \
            double ec = s.started * change / p->rate_scale;                                                            \
            double alpha_e = s.started > 0.0 ? POW(fabs(e), p->tau) + p->floor : 1.0;                                  \
            double alpha_ec = s.started > 0.0 ? POW(fabs(ec), p->tau) + p->floor : 1.0;                                \
            double beta = p->output_gain * (s.started > 0.0 ? POW(fabs(e), p->output_tau) + p->floor : 1.0);           \
            double shape = infer(p, e / alpha_e, ec / alpha_ec);                                                       \
            double error = p->target - s.axis.position, size = fabs(error);                                            \
            s.rho = clipped(beta * shape, -1.0, 1.0);                                                                  \
            s.e = e;                                                                                                   \
            s.started = 1.0;                                                                                           \
            s.squares += error * error * dt;                                                                           \
            s.absolutes += size * dt;                                                                                  \
            s.time += dt;                                                                                              \
            s.largest = size > s.largest ? size : s.largest;                                                           \
            STEP(p, &s.axis, s.rho);                                                                                   \
            if (!(fabs(s.axis.position) <= p->bound && fabs(s.rho) <= p->bound)) {                                     \
                *m = s;                                                                                                \
                return k + 1;                                                                                          \
            }                                                                                                          \
        }                                                                                                              \
        *m = s;                                                                                                        \
        return periods;                                                                                                \
    }

LOOP(hold_portable, portable_pow, hold_step)
LOOP(hold_shortcut, shortcut_pow, hold_step)
LOOP(hold_libm, pow, hold_step)
LOOP(rk4_portable, portable_pow, rk4_step)
LOOP(rk4_shortcut, shortcut_pow, rk4_step)
LOOP(rk4_libm, pow, rk4_step)

/* inference alone, over given points */
void infer_points(const Lathe *p, const double *x, const double *y, double *out, long n)
{
    for (long i = 0; i < n; i++)
        out[i] = infer(p, x[i], y[i]);
}

/* elementary functions alone: independent arguments, and each result the next argument's summand */
#define FUNCTION(NAME, CALL)                                                                                           \
    void NAME##_points(const double *x, double *out, long n)                                                           \
    {                                                                                                                  \
        for (long i = 0; i < n; i++)                                                                                   \
            out[i] = CALL;                                                                                             \
    }

FUNCTION(pow_libm, pow(x[i], 0.9))
FUNCTION(exp_libm, exp(x[i]))
FUNCTION(sin_libm, sin(x[i]))

/* the portable power over given bases and exponents, for the test that it is the kernel's */
void pow_portable_points(const double *x, const double *y, double *out, long n)
{
    for (long i = 0; i < n; i++)
        out[i] = portable_pow(x[i], y[i]);
}
