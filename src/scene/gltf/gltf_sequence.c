// Image sequences in the place of images: what `extras.reframe` of an image says,
//
//     {"frames": "film.####.png", "first": 1, "last": 48}
//
// and what a scene file gives a material: images after those of the document.
#include "scene/gltf/gltf_materials.h"

#include "scene/image_sequence.h"
#include "scene/json/sequence_json.h"
#include "scene/movement.h"

#include <stdlib.h>

// What a scene file shows instead of an image; NULL: it is an image of the document.
static const RfField* find_film( const RfGltf* gltf, int image )
{
    return image >= gltf->counts[RF_GLTF_IMAGES] ? gltf->films + image - gltf->counts[RF_GLTF_IMAGES] : NULL;
}

// `frames` is NULL where the image is one alone.
static RfResult read_sequence( const RfGltf* gltf, int image, RfImageSequence* sequence, const char** frames )
{
    const RfField* film = find_film( gltf, image );
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_IMAGES, image ), field = film != NULL ? *film : rf_gltf_extras( &json );
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

static RfResult find_files( const RfGltf* gltf, int image, const char* frames, char** pattern )
{
    const RfField* film = find_film( gltf, image );
    if ( film == NULL )
        return rf_gltf_resolve_uri( gltf, rf_where( "images[%d]", image ).text, frames, pattern );
    *pattern = rf_path_beside( film->file, frames );
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
    // messages name the file and the place where the sequence is named
    const RfField* film = find_film( gltf, image );
    RfWhere where = film != NULL ? rf_where( "%s", film->path ) : rf_where( "images[%d]", image );
    return result == RF_OK
               ? RF_OK
               : rf_fail( gltf->error, result, "%s: %s: %.560s", film != NULL ? film->file : gltf->path, where.text, error.text );
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
