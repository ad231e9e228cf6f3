#include "cli/render/render_kept.h"

#include "cli/report/report_input.h"
#include "cli/render/render_json.h"
#include "cli/messages.h"
#include "reframe/image.h"

#include <math.h>

// The frames of an older JSON, read in one pass: they are in ascending order.
typedef struct Older
{
    json_t* json; // or NULL
    const json_t* frames;
    size_t next;
} Older;

// Equal up to the last of six digits; two unknown values are equal too.
static bool is_same( double a, double b )
{
    return isnan( a ) || isnan( b ) ? isnan( a ) && isnan( b ) : fabs( a - b ) <= 1e-5 * fabs( b );
}

// Seconds from the older JSON if it describes this very file. If the file was replaced since,
// samples or estimate differ.
static double older_seconds( Older* older, const RfFrameResult* said, int number )
{
    size_t all = json_array_size( older->frames );
    while ( older->next < all && isless( rf_json_number_of( json_array_get( older->frames, older->next ), "frame" ), number ) )
        ++older->next;
    const json_t* row = json_array_get( older->frames, older->next );
    bool is_it = rf_json_number_of( row, "frame" ) == number &&
                 is_same( rf_json_number_of( row, "relmse_estimate" ), said->relmse_estimate ) &&
                 is_same( rf_json_number_of( row, "native_spp" ), said->native_spp );
    return is_it ? rf_json_number_of( row, "seconds" ) : (double)NAN;
}

static json_t* kept_frame_json( const RfRenderOptions* options, const RfCameraPath* path, int frame, Older* older )
{
    char name[RF_PAGE_NAME_SIZE];
    int number = rf_frame_number( path, frame );
    RfFrameResult said = { .frame = frame,
                           .relmse_estimate = (double)NAN,
                           .relmse_likely = (double)NAN,
                           .worst_ten_share = (double)NAN,
                           .flicker_estimate = (double)NAN,
                           .flicker_likely = (double)NAN,
                           .flicker_worst_ten_share = (double)NAN,
                           .native_spp = (double)NAN,
                           .effective_spp = (double)NAN };
    char text[8];
    if ( rf_sequence_name( options->output, number, name, sizeof name, NULL ) == RF_OK )
    {
        said.relmse_is_lower_bound =
            rf_read_exr_string( name, "reframe/relmse-is-lower-bound", text, sizeof text, NULL ) == RF_OK;
        said.relmse_likely = rf_read_exr_number( name, "reframe/relmse-likely" );
        said.worst_ten_share = rf_read_exr_number( name, "reframe/worst-ten-share" );
        said.reached = rf_read_exr_string( name, "reframe/reached", text, sizeof text, NULL ) == RF_OK && text[0] == 'y';
        said.relmse_estimate = rf_read_exr_number( name, "reframe/relmse-estimate" );
        said.flicker_estimate = rf_read_exr_number( name, "reframe/flicker-estimate" );
        said.flicker_is_lower_bound =
            rf_read_exr_string( name, "reframe/flicker-is-lower-bound", text, sizeof text, NULL ) == RF_OK;
        said.flicker_likely = rf_read_exr_number( name, "reframe/flicker-likely" );
        said.flicker_worst_ten_share = rf_read_exr_number( name, "reframe/flicker-worst-ten-share" );
        said.native_spp = rf_read_exr_number( name, "reframe/native-spp" );
        said.effective_spp = rf_read_exr_number( name, "reframe/effective-spp" );
    }
    said.seconds = older_seconds( older, &said, number );
    json_t* json = rf_frame_json( &said, path, &options->settings, -1 );
    json_object_set_new( json, "kept", json_true() );
    return json;
}

json_t* rf_join_kept_frames( const RfRenderOptions* options, const RfCameraPath* path, const int* kept, int count,
                             json_t* rendered )
{
    json_t* frames = json_array();
    Older older = { 0 };
    size_t next = 0, all = json_array_size( rendered );
    if ( count > 0 && rf_load_render_json( options->json, "--json", &older.json, NULL ) == RF_OK )
        older.frames = json_object_get( older.json, "frames" );
    for ( int i = 0; i < count; ++i )
    {
        while ( next < all &&
                isless( rf_json_number_of( json_array_get( rendered, next ), "frame" ), rf_frame_number( path, kept[i] ) ) )
            json_array_append( frames, json_array_get( rendered, next++ ) );
        json_array_append_new( frames, kept_frame_json( options, path, kept[i], &older ) );
    }
    while ( next < all )
        json_array_append( frames, json_array_get( rendered, next++ ) );
    json_decref( older.json );
    return frames;
}
