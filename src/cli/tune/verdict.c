// Gains with their 95 % intervals as phrases for the verdicts of `tune`, `cost` and `plan`.
#include "cli/tune/verdict.h"

#include <math.h>
#include <stdio.h>

void rf_format_gain( const RfInterval* gain, char* text, size_t size )
{
    bool slower = isless( gain->value, 1.0 );
    double value = slower ? 1.0 / gain->value : gain->value;
    if ( !isfinite( value ) )
        snprintf( text, size, "not compared with path tracing" );
    else if ( !isfinite( gain->low ) )
        snprintf( text, size, "%.2f times %s than path tracing at equal noise (too few samples for a confidence interval)", value,
                  slower ? "slower" : "faster" );
    else if ( gain->low <= 1.0 && gain->high >= 1.0 )
        snprintf( text, size, "%s path tracing at equal noise (%.2f times its speed, 95 %%: %.2f to %.2f)",
                  value < 1.1 ? "about as fast as"
                  : slower    ? "possibly slower than"
                              : "possibly faster than",
                  gain->value, gain->low, gain->high );
    else
        snprintf( text, size, "%.2f times %s than path tracing at equal noise (95 %%: %.2f to %.2f)", value,
                  slower ? "slower" : "faster", slower ? 1.0 / gain->high : gain->low, slower ? 1.0 / gain->low : gain->high );
}

void rf_tell_flicker_gain( const RfInterval* gain, char* text, size_t size )
{
    bool slower = isless( gain->value, 1.0 );
    if ( isfinite( gain->value ) )
        snprintf( text, size, "about %.2f times %s than path tracing at equal flicker", slower ? 1.0 / gain->value : gain->value,
                  slower ? "slower" : "faster" );
    else
        snprintf( text, size, "not compared with path tracing" );
}

void rf_format_span( double seconds, char* text, size_t size )
{
    static const struct
    {
        double below, unit;
        const char* name;
    } units[] = { { 120.0, 1.0, "s" }, { 7200.0, 60.0, "min" }, { 172800.0, 3600.0, "h" }, { INFINITY, 86400.0, "days" } };
    int k = 0;
    while ( k < 3 && !isless( seconds, units[k].below ) )
        k += 1;
    double value = seconds / units[k].unit;
    snprintf( text, size, isless( value, 10.0 ) ? "%.2g %s" : "%.0f %s", value, units[k].name );
}

void rf_format_reuse( int eyes, const RfTile* tile, char* text, size_t size )
{
    char name[RF_TILE_NAME_SIZE];
    rf_tile_name( tile, name );
    bool tiles = tile->kind != RF_TILE_NONE;
    if ( eyes > 1 )
        snprintf( text, size, tiles ? "groups of %d and %s tiles" : "groups of %d", eyes, name );
    else if ( tiles )
        snprintf( text, size, "%s tiles", name );
    else
        snprintf( text, size, "path tracing" );
}
