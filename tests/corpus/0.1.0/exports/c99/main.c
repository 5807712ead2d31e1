/* How pd is called: once a control period of 0.001 s, from a timer interrupt or a real-time thread. */
#include "pd_machine.h"

#include <stdio.h>

int main(void)
{
    pd_machine machine;
    double position = 0; /* what the machine would measure */
    double command;      /* what the path asks for */

    pd_machine_init(&machine);
    /* Parameters may be changed here: machine.params.kp = ...; */
    command = machine.max_error > 0 ? machine.max_error / 4 : 1;
    for (int k = 0; k < 10; k++) {
        pd_machine_step(&machine, 1, 0, command, position);
        if (machine.fault != PD_RUNS) {
            printf("fault %d\n", (int)machine.fault);
            return 1;
        }
        printf("period %d: error %g mm, output %g\n", k, (double)machine.error, (double)machine.output);
        position += (command - position) / 10; /* a machine that follows */
    }
    return 0;
}
