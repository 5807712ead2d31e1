/* LinuxCNC HAL component: the machine of the loop "vud_lathe ours.pd fig11a_step_m50", simulated. SPDX-License-Identifier: GPL-2.0-or-later
 * This wrapper includes LinuxCNC's headers, so it is under the GPL; pd_plant.c, which does the work, is not. */
component pd_plant "The machine of ours.pd, simulated: reference, sensor, actuator and plant";

pin out float command "mm";
pin out float feedback "mm";
pin in float output "from the controller, positive moves positive";
pin out u32 periods "control periods so far";

variable pd_plant inside;
function read fp "the start of a period: what the machine shows";
function write fp "the rest of the period, under the controller's output";
option extra_setup yes;
option no_convenience_defines yes;
include "pd_plant_hal.h";
license "GPL";
;;
#define FUNCTION(name) static void name(struct __comp_state *inst, long period)

static int extra_setup(struct __comp_state *inst, char *prefix, long extra_arg)
{
    (void)prefix;
    (void)extra_arg;
    pd_plant_init(&inst->inside);
    return 0;
}

FUNCTION(read)
{
    (void)period;
    pd_plant_read(&inst->inside);
    *inst->command = inst->inside.X[PD_PLANT_COMMAND];
    *inst->feedback = inst->inside.X[PD_PLANT_FEEDBACK];
}

FUNCTION(write)
{
    (void)period;
    inst->inside.X[PD_PLANT_OUTPUT] = -*inst->output;
    pd_plant_write(&inst->inside);
    *inst->periods = (hal_u32_t)inst->inside.counters[0];
}
