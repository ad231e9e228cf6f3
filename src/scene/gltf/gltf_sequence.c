// Image sequences in the place of images: what `extras.reframe` of an image says,
//
//     {"frames": "film.####.png", "first": 1, "last": 48}
//
// and what a scene file gives a material, of which it makes such images after those of the file.
#include "scene/gltf/gltf_materials.h"

#include "scene/image_sequence.h"
#include "scene/json/sequence_json.h"
#include "scene/movement.h"

#include <stdlib.h>

static bool is_added( const RfGltf* gltf, int image ) { return image >= gltf->own_images; }

// Messages name the file and the place where the sequence is named.
static const char* file_of( const RfGltf* gltf, int image )
{
    return is_added( gltf, image ) ? gltf->options->beside : gltf->path;
}

static RfWhere place_of( const RfGltf* gltf, int image )
{
    const char* name = json_string_value( json_object_get( rf_gltf_item( gltf, RF_GLTF_IMAGES, image ), "name" ) );
    return is_added( gltf, image ) ? rf_where( "%s", name ) : rf_where( "images[%d]", image );
}

// `frames` is NULL where the image is one alone.
static RfResult read_sequence( const RfGltf* gltf, int image, RfImageSequence* sequence, const char** frames )
{
    RfField json = rf_gltf_field( gltf, place_of( gltf, image ).text, rf_gltf_item( gltf, RF_GLTF_IMAGES, image ) );
    RfField field = rf_gltf_extras( &json );
    *frames = NULL;
    if ( field.json == NULL )
        return rf_json_result( &json );
    RfResult result = rf_read_sequence( &field, sequence, frames );
    RfFps fps = gltf->options->fps.numerator > 0 ? gltf->options->fps : rf_scene_fps( gltf->scene );
    if ( sequence->fps == 0.0 )
        sequence->fps = (double)fps.numerator / (double)fps.denominator;
    return result;
}

RfResult rf_gltf_plays( const RfGltf* gltf, int image, bool* plays )
{
    RfImageSequence sequence;
    const char* frames;
    RfResult result = read_sequence( gltf, image, &sequence, &frames );
    *plays = result == RF_OK && frames != NULL && sequence.first < sequence.last && !gltf->freeze;
    return result;
}

static RfResult fail( const RfGltf* gltf, int image, RfResult result, const RfError* error )
{
    return rf_fail( gltf->error, result, "%s: %s: %.560s", file_of( gltf, image ), place_of( gltf, image ).text, error->text );
}

static RfResult find_files( const RfGltf* gltf, int image, const char* frames, char** pattern )
{
    if ( !is_added( gltf, image ) )
        return rf_gltf_resolve_uri( gltf, place_of( gltf, image ).text, frames, pattern );
    *pattern = rf_path_beside( gltf->options->beside, frames );
    return *pattern != NULL ? RF_OK : rf_gltf_no_memory( gltf, "images" );
}

// Makes a texture of the image that is there at first, or when all else is frozen.
static RfResult open_sequence( RfGltf* gltf, int image, RfImageSequence* sequence, RfTexture* out )
{
    RfError error = { 0 };
    int number = gltf->freeze ? rf_sequence_number( sequence, gltf->frozen_at ) : sequence->first;
    RfResult result = rf_measure_sequence( sequence, &gltf->scene->content_hash, &error );
    if ( result == RF_OK )
        result = rf_load_sequence_image( sequence, number, out, &error );
    return result == RF_OK ? RF_OK : fail( gltf, image, result, &error );
}

RfResult rf_gltf_load_sequence( RfGltf* gltf, int image, bool srgb, RfTexture* out, bool* given )
{
    RfScene* scene = gltf->scene;
    RfImageSequence sequence;
    const char* frames;
    RfResult result = read_sequence( gltf, image, &sequence, &frames );
    *given = result == RF_OK && frames != NULL;
    if ( !*given )
        return result;
    sequence.srgb = srgb;
    sequence.texture = (int)( out - scene->textures );
    result = find_files( gltf, image, frames, &sequence.pattern );
    if ( result == RF_OK )
        result = open_sequence( gltf, image, &sequence, out );
    bool many = sequence.first < sequence.last;
    if ( result == RF_OK && many && gltf->freeze )
        result = rf_gltf_note_unrendered( gltf, rf_where( "image '%.80s'", frames ).text, "it is one of a sequence" );
    if ( result != RF_OK || !many || gltf->freeze )
    {
        free( sequence.pattern );
        return result;
    }
    out->plays = true;
    out->largest = fmaxf( out->largest, 1.0f );
    return rf_add_sequence( scene, &sequence ) ? RF_OK : rf_gltf_no_memory( gltf, "images" );
}

void rf_gltf_limit_sequence( RfGltf* gltf, int texture, double most )
{
    RfMovement* movement = gltf->scene->movement;
    for ( int i = 0; movement != NULL && i < movement->sequence_count; ++i )
    {
        RfImageSequence* sequence = movement->sequences + i;
        if ( sequence->texture == texture )
            sequence->most = fmin( sequence->most, most );
    }
}
