#include "cli/report/report_numbers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void rf_format_count( double count, char text[32] )
{
    static const char* const units[] = { "", " k", " M", " G", " T" };
    int unit = 0;
    while ( count >= 1000.0 && unit < 4 )
    {
        count /= 1000.0;
        ++unit;
    }
    snprintf( text, 32, unit == 0 ? "%.0f%s" : "%.3g%s", count, units[unit] );
}

void rf_format_bytes( double bytes, char text[32] )
{
    char count[32];
    rf_format_count( bytes, count );
    snprintf( text, 32, "%.20s%sB", count, strchr( count, ' ' ) != NULL ? "" : " " );
}

void rf_format_seconds( double seconds, char text[32] )
{
    double minutes = floor( seconds / 60.0 ), hours = floor( seconds / 3600.0 );
    if ( seconds < 100.0 )
        snprintf( text, 32, "%.3g s", seconds );
    else if ( hours < 1.0 )
        snprintf( text, 32, "%.0f min %.0f s", minutes, seconds - 60.0 * minutes );
    else
        snprintf( text, 32, "%.0f h %.0f min", hours, minutes - 60.0 * hours );
}
