/* ours.pd, exported by Leadscrew from duty_pd.
 * Exported code belongs to whoever exported it. The parts that come from Leadscrew (the ls_ functions and the machine
 * layer) are under the BSD 3-clause licence; the README beside this file has its text. */

#include "pd.h"

#include <float.h>
#include <math.h>
#include <stdint.h>

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: it changes the results"
#endif
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "this target computes with more digits than a double has; on 32-bit x86 compile with -msse2 -mfpmath=sse"
#endif

/* The gains as the step reads them. */
typedef struct pd_DutyPD {
    double kp;
    double t_d;
    double kept; /* Share of the filtered derivative that stays over a period. */
} pd_DutyPD;

/* The last error and the filtered derivative. */
typedef struct pd_DutyPDState {
    double error; /* mm */
    double derivative; /* mm/s */
    double rho; /* duty */
    double started; /* 0 before the first period, then 1 */
} pd_DutyPDState;

typedef struct pd_DutyPDState_and_value {
    pd_DutyPDState next;
    double value;
} pd_DutyPDState_and_value;

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

/* The duty against the error and its filtered derivative.
 * duty_pd.py:50 */
static pd_DutyPDState_and_value duty_pd(pd_DutyPD p, pd_DutyPDState s, double command, double feedback, double dt)
{
    const double error = command - feedback;
    const double raw = s.started * (error - s.error) / dt;
    const double derivative = p.kept * s.derivative + (1.0 - p.kept) * raw;
    const double flushed = fabs(derivative) > 1e-30 ? derivative : 0.0;
    const double rho = ls_minimum(1.0, ls_maximum(-1.0, -p.kp * (error + p.t_d * flushed)));
    return (pd_DutyPDState_and_value){(pd_DutyPDState){.error = error, .derivative = flushed, .rho = rho,
        .started = 1.0}, rho};
}

void pd_defaults(pd_params *params)
{
    static const pd_params exported = {
        .period = 0.001,
        .kp = 0.2505263157894737,
        .t_d = 0.0154,
        .kept = 0.16232061118184818,
    };

    *params = exported;
}

void pd_start(const pd_params *params, pd_state *state)
{
    static const pd_state fresh = {
        .error = 0.0,
        .derivative = 0.0,
        .rho = 0.0,
        .started = 0.0,
        .periods = 0,
    };

    *state = fresh;
    (void)params;
}

double pd_step(const pd_params *params, pd_state *state, double command, double feedback)
{
    const pd_DutyPD p = {.kp = params->kp, .t_d = params->t_d, .kept = params->kept};
    const pd_DutyPDState s = {.error = state->error, .derivative = state->derivative, .rho = state->rho,
        .started = state->started};
    const pd_DutyPDState_and_value r = duty_pd(p, s, command, feedback, params->period);

    state->error = r.next.error;
    state->derivative = r.next.derivative;
    state->rho = r.next.rho;
    state->started = r.next.started;
    state->periods++;
    return r.value;
}
