// What float code computes against references in double precision, over random inputs and the corners of their ranges. The
// argument is the number of inputs per function; see README.md.
#include "differential/differential.h"

#include "base/float_traps.h"
#include "trace/trace.h"

#include <stdio.h>
#include <stdlib.h>

#ifdef REFRAME_SANITIZED
#define COUNT 6000
#else
#define COUNT 60000
#endif

int main( int argc, char** argv )
{
    rf_set_float_mode();
    rf_pause_float_traps(); // references say by NaN what is not defined
    long count = getenv( "REFRAME_LONG" ) != NULL ? 2000000 : COUNT;
    if ( argc > 1 )
        count = strtol( argv[1], NULL, 10 );
    print_head();
    int bad = check_cameras( count ) + check_models( count ) + check_sampling( count ) + check_glass( count ) +
              check_lights( count ) + check_tiles( count );
    fprintf( stderr, "%d rows over their limits\n", bad );
    return bad > 0;
}
