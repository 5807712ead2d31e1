/* Replays the golden vectors through pd_step() and compares every output bit for bit.
 * Exported code belongs to whoever exported it. The parts that come from Leadscrew (the ls_ functions and the machine
 * layer) are under the BSD 3-clause licence; the README beside this file has its text. */
#include "pd.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COLUMNS 3

int main(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "golden.csv";
    FILE *file = fopen(name, "r");
    char line[160];
    pd_params params;
    pd_state state;
    long cycles = 0;
    long different = 0;
    double worst = 0.0;

    if (file == NULL) {
        fprintf(stderr, "%s cannot be read\n", name);
        return 2;
    }
    pd_defaults(&params);
    pd_start(&params, &state);
    if (fgets(line, sizeof line, file) == NULL) { /* the names of the columns */
        fprintf(stderr, "%s is empty\n", name);
        return 2;
    }
    while (fgets(line, sizeof line, file) != NULL) {
        double x[COLUMNS];
        double got[1];
        char *at = line;

        for (int i = 0; i < COLUMNS; i++) {
            char *end;

            x[i] = strtod(at, &end);
            if (end == at) {
                fprintf(stderr, "%s: row %ld is not a row of %d numbers\n", name, cycles + 1, COLUMNS);
                return 2;
            }
            at = *end == ',' ? end + 1 : end;
        }
        got[0] = pd_step(&params, &state, x[0], x[1]);
        for (int i = 0; i < 1; i++) {
            const double value = got[i];
            const double expected = x[2 + i];

            if (memcmp(&value, &expected, sizeof value) != 0 && !(isnan(value) && isnan(expected))) {
                const double difference = fabs(value - expected);

                worst = difference > worst || isnan(difference) ? difference : worst;
                different++;
            }
        }
        cycles++;
    }
    fclose(file);
    printf("cycles %ld different %ld worst %.17g\n", cycles, different, worst);
    return cycles > 0 && different == 0 ? 0 : 1;
}
