/* ours.pd, exported by Leadscrew from duty_pd.
 * Exported code belongs to whoever exported it. The parts that come from Leadscrew (the ls_ functions and the machine
 * layer) are under the BSD 3-clause licence; the README beside this file has its text. */

#ifndef PD_H
#define PD_H

#include <math.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The gains as the step reads them. */
typedef struct pd_params {
    double period; /* control period, s */
    double kp;
    double t_d;
    double kept; /* Share of the filtered derivative that stays over a period. */
} pd_params;

/* The last error and the filtered derivative. */
typedef struct pd_state {
    double error; /* mm */
    double derivative; /* mm/s */
    double rho; /* duty */
    double started; /* 0 before the first period, then 1 */
    int64_t periods; /* control periods since the start */
} pd_state;

/* The parameters as exported. */
void pd_defaults(pd_params *params);

/* The state at the start. */
void pd_start(const pd_params *params, pd_state *state);

/* One control period: from command and feedback to the output. */
double pd_step(const pd_params *params, pd_state *state, double command, double feedback);

#ifdef __cplusplus
}
#endif

#endif
