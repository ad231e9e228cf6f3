// Gains with their 95 % intervals as phrases for the verdicts of `tune` and `cost`.
#include "cli/tune/verdict.h"

#include <math.h>
#include <stdio.h>

#define WIDEST 4.0 // times the lower end of its interval: the upper one of a figure that is printed

bool rf_is_known( const RfInterval* value )
{
    return isfinite( value->value ) && isgreater( value->low, 0.0 ) && islessequal( value->high, WIDEST * value->low );
}

// What is said of a gain of which so little is known; an interval shrinks as the root of the time.
static void format_unknown( const RfInterval* gain, double spent, char* text, size_t size )
{
    char span[32];
    double width = log( gain->high / gain->low ) / log( WIDEST );
    rf_format_span( spent * width * width, span, sizeof span );
    if ( isgreater( gain->low, 1.0 ) )
        snprintf( text, size, "at least %.2g times faster than path tracing at equal noise", gain->low );
    else if ( isless( gain->high, 1.0 ) )
        snprintf( text, size, "at least %.2g times slower than path tracing at equal noise", 1.0 / gain->high );
    else if ( isfinite( width ) )
        snprintf( text, size, "gain over path tracing not known within the budget: needs about %s", span );
    else
        snprintf( text, size, "gain over path tracing not known within the budget" );
}

void rf_format_gain( const RfInterval* gain, double spent, char* text, size_t size )
{
    bool slower = isless( gain->value, 1.0 );
    double value = slower ? 1.0 / gain->value : gain->value;
    if ( !isfinite( value ) )
        snprintf( text, size, "not compared with path tracing" );
    else if ( !rf_is_known( gain ) )
        format_unknown( gain, spent, text, size );
    else if ( gain->low <= 1.0 && gain->high >= 1.0 )
        snprintf( text, size, "%s path tracing at equal noise (%.2f times its speed, 95 %%: %.2f to %.2f)",
                  value < 1.1 ? "about as fast as"
                  : slower    ? "possibly slower than"
                              : "possibly faster than",
                  gain->value, gain->low, gain->high );
    else
        snprintf( text, size, "%.2g times %s than path tracing at equal noise (95 %%: %.2g to %.2g)", value,
                  slower ? "slower" : "faster", slower ? 1.0 / gain->high : gain->low, slower ? 1.0 / gain->low : gain->high );
}

void rf_format_figure( const RfInterval* value, char text[RF_FIGURE_SIZE] )
{
    if ( rf_is_known( value ) )
        snprintf( text, RF_FIGURE_SIZE, "%.3g", value->value );
    else if ( isfinite( value->low ) && isgreater( value->low, 0.0 ) )
        snprintf( text, RF_FIGURE_SIZE, ">%.2g", value->low );
    else
        snprintf( text, RF_FIGURE_SIZE, "?" );
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
