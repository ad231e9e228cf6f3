#include "cli/compare/compare_report.h"

#include "cli/messages.h"
#include "image/sequence.h"
#include "measure/error.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void rf_print_error_head( void )
{
    printf( "%7s  %11s  %11s  %11s  %11s  %11s  %6s  %6s\n", "frame", "relMSE", "trimmed", "MSE", "bias", "max", "NaN", "Inf" );
}

void rf_print_error_row( const char* frame, const RfErrorMetrics* metrics )
{
    printf( "%7s  %11.4e  %11.4e  %11.4e  %+11.4e  %11.4e  %6zu  %6zu\n", frame, metrics->relmse, metrics->relmse_trimmed,
            metrics->mse, metrics->bias, metrics->max, metrics->nan + metrics->reference_nan,
            metrics->inf + metrics->reference_inf );
}

static void set_metrics( json_t* object, const RfErrorMetrics* metrics )
{
    json_object_set_new( object, "relmse", rf_json_number( metrics->relmse ) );
    json_object_set_new( object, "relmse_trimmed", rf_json_number( metrics->relmse_trimmed ) );
    json_object_set_new( object, "mse", rf_json_number( metrics->mse ) );
    json_object_set_new( object, "bias", rf_json_number( metrics->bias ) );
    json_object_set_new( object, "bias_low", rf_json_number( metrics->bias_low ) );
    json_object_set_new( object, "bias_high", rf_json_number( metrics->bias_high ) );
    json_object_set_new( object, "max", rf_json_number( metrics->max ) );
    json_object_set_new( object, "nan", json_integer( (json_int_t)metrics->nan ) );
    json_object_set_new( object, "inf", json_integer( (json_int_t)metrics->inf ) );
    json_object_set_new( object, "reference_nan", json_integer( (json_int_t)metrics->reference_nan ) );
    json_object_set_new( object, "reference_inf", json_integer( (json_int_t)metrics->reference_inf ) );
    json_object_set_new( object, "reference_mean", rf_json_number( metrics->reference_mean ) );
}

static json_t* worst_json( int frame, const RfWorstPixel* worst )
{
    return worst->frame < 0 ? json_null()
                            : json_pack( "{s:i, s:i, s:i, s:o}", "frame", frame, "x", worst->x, "y", worst->y, "relative",
                                         rf_json_number( worst->relative ) );
}

json_t* rf_error_frame_json( int frame, const RfErrorMetrics* metrics )
{
    json_t* row = json_object();
    json_object_set_new( row, "frame", json_integer( frame ) );
    set_metrics( row, metrics );
    json_object_set_new( row, "worst", worst_json( frame, &metrics->worst ) );
    return row;
}

json_t* rf_error_json( json_t* rows, const RfErrorMetrics* metrics, int worst_frame, const char* verdict )
{
    json_t* object = json_object();
    json_object_set_new( object, "frames", rows );
    set_metrics( object, metrics );
    json_object_set_new( object, "worst", worst_json( worst_frame, &metrics->worst ) );
    json_object_set_new( object, "verdict", rf_json_text( verdict ) );
    return object;
}

static void append( char* text, size_t size, const char* more )
{
    size_t used = strlen( text );
    snprintf( text + used, size - used, "%s", more );
}

// In percent of the reference's brightness, where it has one.
static void say_bias( const RfErrorMetrics* m, char* text, size_t size )
{
    bool relative = m->reference_mean > 0.0;
    double scale = relative ? 100.0 / m->reference_mean : 1.0, bias = m->bias * scale;
    const char* unit = relative ? " %" : "";
    char part[256];
    if ( !isfinite( m->bias_low ) )
        snprintf( part, sizeof part, "mean error %+.2g%s (too few pixels to tell bias from noise)", bias, unit );
    else
    {
        double low = m->bias_low * scale, high = m->bias_high * scale;
        const char* what = low > 0.0 ? "bias seen, too bright" : high < 0.0 ? "bias seen, too dark" : "no bias seen";
        snprintf( part, sizeof part, "%s: mean error %+.2g%s (95 %%: %+.2g to %+.2g%s)", what, bias, unit, low, high, unit );
    }
    append( text, size, part );
}

// relMSE adds up three channels: the error of one is the root of a third. Of a
// picture that is off everywhere it is not noise.
static bool is_offset( const RfErrorMetrics* m ) { return m->bias * m->bias > 0.5 * m->mse; }

static void say_noise( const RfErrorMetrics* m, char* text, size_t size )
{
    char part[256], percent[16];
    snprintf( percent, sizeof percent, "%.2g %%", 100.0 * sqrt( m->relmse / 3.0 ) );
    snprintf( part, sizeof part,
              is_offset( m ) ? "; relMSE %.3g, a pixel is off by about %s in each channel"
                             : "; relMSE %.3g, about %s of noise in each channel of a pixel",
              m->relmse, percent );
    append( text, size, part );
    if ( m->relmse_trimmed < 0.5 * m->relmse )
    {
        snprintf( part, sizeof part, " (%.2g %% without the worst 0.1 %% of the pixels)",
                  100.0 * sqrt( m->relmse_trimmed / 3.0 ) );
        append( text, size, part );
    }
}

void rf_error_verdict( const RfErrorMetrics* m, int worst_frame, char* text, size_t size )
{
    text[0] = '\0';
    if ( rf_has_no_error( m ) )
    {
        append( text, size, "no error can be reported: there are values that are no numbers" );
        return;
    }
    if ( m->max == 0.0 )
    {
        append( text, size, "no difference: every pixel is the same" );
        return;
    }
    say_bias( m, text, size );
    say_noise( m, text, size );
    char part[128], frame[32] = "";
    if ( worst_frame >= 0 )
        snprintf( frame, sizeof frame, " of frame %d", worst_frame );
    if ( m->worst.frame >= 0 )
    {
        snprintf( part, sizeof part, "; worst pixel (%d, %d)%s, off by %.2g %%", m->worst.x, m->worst.y, frame,
                  100.0 * sqrt( m->worst.relative / 3.0 ) );
        append( text, size, part );
    }
}

static void print_not_measured( const char* lacking, const int* frames, int count )
{
    char text[256];
    rf_format_frames( frames, count, text, sizeof text );
    if ( count > 0 )
        rf_print( "not measured, for %s %s: frame%s %s\n", lacking, count == 1 ? "it" : "them", count == 1 ? "" : "s", text );
}

void rf_print_missing( const RfCompareFrames* frames )
{
    print_not_measured( "both sequences lack", frames->missing, frames->missing_count );
    for ( int i = 0; i < 2; ++i )
    {
        char lacking[RF_COMPARE_NAME_SIZE + 16];
        snprintf( lacking, sizeof lacking, "%s lacks", frames->patterns[i] );
        print_not_measured( lacking, frames->lacking[i], frames->lacking_count[i] );
    }
}

void rf_set_missing( json_t* json, const RfCompareFrames* frames )
{
    json_object_set_new( json, "missing", rf_json_frames( frames->missing, frames->missing_count ) );
    json_object_set_new( json, "missing_a", rf_json_frames( frames->lacking[0], frames->lacking_count[0] ) );
    json_object_set_new( json, "missing_b", rf_json_frames( frames->lacking[1], frames->lacking_count[1] ) );
}
