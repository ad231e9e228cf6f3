// Pixels that frames clip: from their headers into JSON and a warning.
#include "cli/render/clipped_pixels.h"

#include "base/words.h"
#include "cli/messages.h"
#include "image/sequence.h"
#include "output/frame_file.h"
#include "reframe/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_NAME 4096

#define MOST_TEXT 160 // characters of a list of frames

void rf_add_clipped( const char* pattern, int number, json_t* row )
{
    char name[MAX_NAME], text[RF_EFFECTS_TEXT_SIZE];
    bool named = rf_sequence_name( pattern, number, name, sizeof name, NULL ) == RF_OK;
    double pixels = named ? rf_read_exr_number( name, rf_key_name( RF_KEY_CLIPPED_PIXELS ) ) : 0.0;
    json_object_set_new( row, "clipped_pixels", json_integer( isgreater( pixels, 0.0 ) ? (json_int_t)pixels : 0 ) );
    if ( !named || rf_read_exr_string( name, rf_key_name( RF_KEY_CLIPPED_LAYERS ), text, sizeof text, NULL ) != RF_OK )
        return;
    json_t* layers = json_array();
    for ( char *layer = text, *end; layer != NULL; layer = end )
    {
        end = strchr( layer, ',' );
        if ( end != NULL )
            *end++ = '\0';
        json_array_append_new( layers, rf_json_text( layer ) );
    }
    json_object_set_new( row, "clipped_layers", layers );
}

// Appends the words of a list that the text lacks.
static void join_words( const json_t* list, char* text, size_t size )
{
    size_t i;
    const json_t* word;
    json_array_foreach( list, i, word )
    {
        char whole[2 * RF_EFFECTS_TEXT_SIZE], item[RF_EFFECTS_TEXT_SIZE];
        snprintf( whole, sizeof whole, ", %s,", text );
        snprintf( item, sizeof item, ", %s,", json_string_value( word ) );
        if ( strstr( whole, item ) == NULL )
            rf_append( text, size, "%s%s", text[0] != '\0' ? ", " : "", json_string_value( word ) );
    }
}

json_t* rf_sum_clipped( const json_t* frames )
{
    size_t i;
    const json_t* row;
    json_int_t pixels = 0;
    json_array_foreach( frames, i, row ) pixels += json_integer_value( json_object_get( row, "clipped_pixels" ) );
    return json_integer( pixels );
}

static int compare_ints( const void* a, const void* b ) { return *(const int*)a - *(const int*)b; }

void rf_warn_of_clipped( RfRenderJob* job )
{
    const RfFrameFiles* files = &job->options.settings.files;
    json_t *rows = json_array(), *row;
    char text[MOST_TEXT], layers[256] = "";
    size_t i, rendered = json_array_size( job->frames_json );
    int *numbers = malloc( ( rendered + (size_t)job->kept_count + 1 ) * sizeof *numbers ), count = 0;
    json_int_t pixels = 0;
    json_array_extend( rows, job->frames_json );
    for ( int k = 0; k < job->kept_count; ++k )
    {
        int number = rf_frame_number( &job->path, job->kept[k] );
        row = json_pack( "{s:i}", "frame", number );
        rf_add_clipped( job->options.output, number, row );
        json_array_append_new( rows, row );
    }
    json_array_foreach( rows, i, row )
    {
        json_int_t here = json_integer_value( json_object_get( row, "clipped_pixels" ) );
        if ( here <= 0 || numbers == NULL )
            continue;
        pixels += here;
        numbers[count++] = (int)json_integer_value( json_object_get( row, "frame" ) );
        join_words( json_object_get( row, "clipped_layers" ), layers, sizeof layers );
    }
    if ( count > 0 )
    {
        bool dwa = files->compression == RF_EXR_DWAA || files->compression == RF_EXR_DWAB;
        qsort( numbers, (size_t)count, sizeof *numbers, compare_ints );
        rf_format_frames( numbers, count, text, sizeof text );
        rf_warn( &job->log, "%lld pixel%s of frame%s %s %s beyond the range of %s and clipped there, in %s: %s",
                 (long long)pixels, pixels == 1 ? "" : "s", count == 1 ? "" : "s", text, pixels == 1 ? "is" : "are",
                 dwa ? "DWA (30000; half floats: 65504)" : "half floats (65504)", layers,
                 dwa ? "give --compression zip and --float" : "give --float" );
    }
    free( numbers );
    json_decref( rows );
}
