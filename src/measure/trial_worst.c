// The cells with the most error of a trial.
#include "measure/trial.h"

void rf_keep_worst_cell( double worst[RF_WORST_CELLS], double relmse )
{
    for ( int k = 0; k < RF_WORST_CELLS; ++k )
    {
        if ( relmse <= worst[k] )
            continue;
        double next = worst[k];
        worst[k] = relmse;
        relmse = next;
    }
}
