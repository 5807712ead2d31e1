/* ours.pd for LinuxCNC: what pd.comp keeps for each instance, and the controller itself.
 * Exported code belongs to whoever exported it. The parts that come from Leadscrew (the ls_ functions and the machine
 * layer) are under the BSD 3-clause licence; the README beside this file has its text. */
#ifndef PD_HAL_H
#define PD_HAL_H

/* A product and a sum must round twice, as they did where the controller was recorded. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("-ffp-contract=off")
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0
#warning "this processor's arithmetic carries extra digits: the golden vectors will not be met in every bit"
#endif

#include "pd.c"
#include "pd_machine.c"

typedef struct pd_hal {
    pd_machine machine;
    long period;        /* of the thread, ns */
    int wait;           /* calls to leave out before the next step */
    int usable;         /* whether the thread's period suits the controller */
    int bad_reported;   /* whether an unsuitable value has been reported */
    char name[48];      /* of the instance */
    double held_maxoutput; /* last good value */
    double held_max_following_error; /* last good value */
    double held_max_wrong_way; /* last good value */
    double held_kp; /* last good value */
    double held_t_d; /* last good value */
} pd_hal;

/* LinuxCNC keeps every instance in 256 kB of shared memory, with all the other components. */
_Static_assert(sizeof(pd_hal) <= 65536, "this controller's state is too large for LinuxCNC's HAL memory");

#endif
