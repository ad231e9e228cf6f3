// --shutter, --fstop and --focus.
#include "cli/options/render_options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_SHUTTER 100.0 // frames

static bool parse_number( const char* text, const char* end, double* number )
{
    char* stop;
    *number = strtod( text, &stop );
    return stop == end && stop > text && isfinite( *number ) != 0;
}

static bool parse_shutter( const char* text, double shutter[2] )
{
    const char *end = text + strlen( text ), *comma = strchr( text, ',' );
    double length;
    if ( comma != NULL )
        return parse_number( text, comma, shutter ) && parse_number( comma + 1, end, shutter + 1 ) && shutter[0] <= shutter[1] &&
               shutter[0] >= -MAX_SHUTTER && shutter[1] <= MAX_SHUTTER;
    if ( !parse_number( text, end, &length ) || length < 0.0 || length > MAX_SHUTTER )
        return false;
    shutter[0] = -0.5 * length;
    shutter[1] = 0.5 * length;
    return true;
}

RfResult rf_parse_lens_options( const RfRenderOptions* options, RfLens* lens, RfError* error )
{
    *lens = ( RfLens ){ .has_shutter = options->shutter != NULL, .has_fstop = options->fstop_given, .fstop = options->fstop };
    if ( options->shutter != NULL && !parse_shutter( options->shutter, lens->shutter ) )
        return rf_fail( error, RF_ERROR_USAGE,
                        "--shutter %.80s: want frames, 0 to %g, as 0.5, or when it opens and closes, as -0.25,0.25",
                        options->shutter, MAX_SHUTTER );
    if ( options->focus == NULL )
        return RF_OK;
    bool number = parse_number( options->focus, options->focus + strlen( options->focus ), &lens->focus );
    if ( number && !( lens->focus > 0.0 && lens->focus <= 1e6 ) )
        return rf_fail( error, RF_ERROR_USAGE, "--focus %.80s: want metres above 0, or the name of a node", options->focus );
    if ( !number )
        lens->focus = 0.0;
    lens->focus_node = number ? NULL : options->focus;
    return RF_OK;
}
