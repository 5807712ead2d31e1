/* pd_plant for LinuxCNC: the simulated machine itself, compiled into its component.
 * Exported code belongs to whoever exported it. The parts that come from Leadscrew (the ls_ functions and the machine
 * layer) are under the BSD 3-clause licence; the README beside this file has its text. */
#ifndef PD_PLANT_HAL_H
#define PD_PLANT_HAL_H

/* A product and a sum must round twice, as they did where the loop was recorded. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("-ffp-contract=off")
#endif

#include "pd_plant.c"

/* LinuxCNC keeps every instance in 256 kB of shared memory, with all the other components. */
_Static_assert(sizeof(pd_plant) <= 131072, "this machine's state is too large for LinuxCNC's HAL memory");

#endif
