/* ours.pd at the machine: enable, signs, limits and faults around pd_step().
 * Exported code belongs to whoever exported it. The parts that come from Leadscrew (the ls_ functions and the machine
 * layer) are under the BSD 3-clause licence; the README beside this file has its text.
 * Command and feedback in machine units, error = command - feedback, a positive output moves the axis towards
 * positive feedback (the controller's own sign is the opposite and is turned here).
 * Numbers are double. */
#ifndef PD_MACHINE_H
#define PD_MACHINE_H

#include "pd.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Why the outputs are held at zero; cleared by taking enable away. */
typedef enum pd_fault {
    PD_RUNS = 0,
    PD_NOT_FINITE = 1,     /* an input or the output was not a finite number */
    PD_FOLLOWING_ERROR = 2, /* |error| above max_error */
    PD_WRONG_WAY = 3       /* the feedback moved against the output by more than max_wrong_way */
} pd_fault;

typedef struct pd_machine {
    pd_params params;
    pd_state state;

    /* limits; 0: none */
    double max_output;    /* size of an output, 1 */
    double max_error;     /* size of the following error, mm */
    double max_wrong_way; /* way against the output that should close the error, braking left out, mm */

    /* results of the last step */
    double output; /* to the drive, 1 */
    double error;         /* command - feedback, mm */
    int enabled;       /* whether the controller runs */
    int saturated;     /* whether an output is at max_output */
    pd_fault fault;

    /* inside */
    int index_enable;  /* as it was in the last step */
    int moving;        /* whether there is a last step to compare with */
    double offset;        /* added to command and feedback since the last index */
    double last_feedback; /* with offset */
    double last_move;     /* change of the feedback in the last step */
    double wrong_way;     /* way against the output so far */
} pd_machine;

/* The controller as exported, disabled. */
void pd_machine_init(pd_machine *m);

/* One control period. enable: run, or hold the outputs at zero. index_enable: as LinuxCNC has it; when it falls, the
   coordinates jump and the controller is not to notice. */
void pd_machine_step(pd_machine *m, int enable, int index_enable, double command, double feedback);

#ifdef __cplusplus
}
#endif

#endif
