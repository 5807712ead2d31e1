/* The machine of the loop "vud_lathe ours.pd fig11a_step_m50", simulated: everything but its controller.
 * Exported code belongs to whoever exported it. The parts that come from Leadscrew (the ls_ functions and the machine
 * layer) are under the BSD 3-clause licence; the README beside this file has its text. */
#ifndef PD_PLANT_H
#define PD_PLANT_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* All numbers of the machine, side by side; shown and taken lie in X. */
typedef struct pd_plant {
    double P[43];
    double A[1];
    double S[42];
    double B[1];
    double X[4];
    int64_t counters[2]; /* [0]: control periods so far */
} pd_plant;

void pd_plant_init(pd_plant *m);

/* The start of a period: what the machine shows. */
void pd_plant_read(pd_plant *m);

/* The rest of the period, under the output that the controller gave. */
void pd_plant_write(pd_plant *m);

#define PD_PLANT_COMMAND 0 /* place in X, mm */
#define PD_PLANT_FEEDBACK 1 /* place in X, mm */
#define PD_PLANT_OUTPUT 3 /* place in X */

#ifdef __cplusplus
}
#endif

#endif
