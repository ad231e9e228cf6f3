// Textures of materials: their images, their uses, and what makes a material vary.
#include "base/remedy.h"
#include "base/try.h"
#include "base/words.h"
#include "gltf/gltf_document.h"

#include "base/file.h"
#include "base/system.h"
#include "image/decode.h"
#include "scene/texture.h"
#include "scene/shared_json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Image sequences in the place of images: what `extras.reframe` of an image says,
//
//     {"frames": "film.####.png", "first": 1, "last": 48}
//
// and what a scene file gives a material: images after those of the document.

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

// Whether an image is a sequence of several that are not frozen.
static RfResult does_play( const RfGltf* gltf, int image, bool* plays )
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

// Makes a texture of the scene of a sequence, if the image is one, which `given` says.
static RfResult load_sequence( RfGltf* gltf, int image, bool srgb, RfTexture* out, bool* given )
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

// Limits the values of the images that a texture of the scene shows.
static void limit_sequence( RfGltf* gltf, int texture, double most )
{
    RfMovement* movement = gltf->scene->movement;
    for ( int i = 0; movement != NULL && i < movement->sequence_count; ++i )
    {
        RfImageSequence* sequence = movement->sequences + i;
        if ( sequence->texture == texture )
            sequence->most = fmin( sequence->most, most );
    }
}

// Images: decodes those that materials of triangles use, once per colour space in which they
// are used.

// An encoded image.
typedef struct Encoded
{
    const uint8_t* bytes;
    size_t size;
    uint8_t* owned;
    bool outside; // in a file of its own, which the hash of the scene lacks
} Encoded;

static RfResult read_encoded( RfGltf* gltf, int index, const char* where, Encoded* out )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_IMAGES, index );
    const char* uri = NULL;
    RfResult result = rf_get_text( &json, "uri", &uri );
    int view = rf_gltf_get_index( gltf, &json, "bufferView", RF_GLTF_BUFFER_VIEWS );
    if ( rf_json_result( &json ) != RF_OK )
        return rf_json_result( &json );
    if ( ( uri != NULL ) == ( view >= 0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "must have either uri or bufferView" );
    result = uri != NULL ? rf_gltf_read_uri( gltf, where, uri, RF_MAX_IMAGE_BYTES, &out->owned, &out->size )
                         : rf_gltf_whole_view( gltf, where, view, INT64_MAX, &out->bytes, &out->size );
    out->outside = result == RF_OK && uri != NULL && !rf_is_data_uri( uri );
    out->bytes = out->owned != NULL ? out->owned : out->bytes;
    return result;
}

static RfResult load_image( RfGltf* gltf, int index, bool srgb, RfTexture* out )
{
    RfWhere where = rf_where( "images[%d]", index );
    Encoded encoded = { 0 };
    RfPixels pixels = { 0 };
    RfError error;
    bool plays;
    RfResult result = load_sequence( gltf, index, srgb, out, &plays );
    if ( result != RF_OK || plays )
        return result;
    result = read_encoded( gltf, index, where.text, &encoded );
    if ( encoded.outside )
        gltf->scene->content_hash = rf_hash_bytes( gltf->scene->content_hash, encoded.owned, encoded.size );
    if ( result == RF_OK )
    {
        result = rf_decode_image( encoded.bytes, encoded.size, where.text, &pixels, &error );
        // the message begins with `where`
        if ( result != RF_OK )
            rf_fail( gltf->error, result, "%s: %s", gltf->path, error.text );
    }
    free( encoded.owned );
    if ( result == RF_OK )
        result = rf_make_texture( rf_where( "%.100s: %s", gltf->path, where.text ).text, &pixels, srgb, out, gltf->error );
    if ( result == RF_OK && out->outside > 1e-4 )
        rf_warn( gltf->log, "%s: %s has colours outside Rec. 709, which are clipped: %.2g %% of its light", gltf->path,
                 where.text, 100.0 * out->outside );
    if ( result == RF_OK && srgb && !rf_make_mip_levels( out ) )
        result = rf_gltf_no_memory( gltf, where.text );
    rf_destroy_pixels( &pixels );
    return result;
}

#define UNUSED -1
#define LOST -2

// Takes note of an image that cannot be read, for all are told at once; other errors stay.
static RfResult lose_image( RfGltf* gltf, RfResult result, int* numbers )
{
    RfScene* scene = gltf->scene;
    if ( result != RF_ERROR_IO && result != RF_ERROR_FORMAT && result != RF_ERROR_UNSUPPORTED && result != RF_ERROR_SCENE )
        return result;
    size_t path = strlen( gltf->path );
    bool named = strncmp( gltf->error->text, gltf->path, path ) == 0 && strncmp( gltf->error->text + path, ": ", 2 ) == 0;
    const char* text = gltf->error->text + ( named ? path + 2 : 0 );
    if ( !rf_gltf_grow( &scene->losses, scene->loss_count, sizeof *scene->losses ) ||
         ( scene->losses[scene->loss_count] = strdup( text ) ) == NULL )
        return rf_gltf_no_memory( gltf, "images" );
    scene->loss_count += 1;
    gltf->lost = result;
    rf_destroy_texture( scene->textures + --scene->texture_count );
    numbers[0] = numbers[1] = LOST;
    gltf->error->code = RF_OK; // what follows is read
    return RF_OK;
}

// `numbers` maps each image and colour space to a texture index. A material without an image that cannot be read is what it is
// without the texture, but emits nothing.
static RfResult resolve_textures( RfGltf* gltf, RfMaterial* material, int* numbers )
{
    RfScene* scene = gltf->scene;
    for ( int slot = 0; slot < RF_TEXTURE_SLOT_COUNT; ++slot )
    {
        int* use = &material->textured->refs[slot].texture;
        if ( *use < 0 )
            continue;
        if ( numbers[*use] == UNUSED )
        {
            numbers[*use] = scene->texture_count++;
            RfResult result = load_image( gltf, *use / 2, *use % 2 == 1, scene->textures + numbers[*use] );
            RF_TRY( result == RF_OK ? RF_OK : lose_image( gltf, result, numbers + *use / 2 * 2 ) );
        }
        if ( numbers[*use] == LOST && slot == RF_TEXTURE_EMISSIVE )
            material->emission = rf_vec3( 0.0f, 0.0f, 0.0f );
        *use = numbers[*use] == LOST ? -1 : numbers[*use];
    }
    return RF_OK;
}

// Warns of images that cannot be read, or fails with all of them.
static RfResult tell_losses( RfGltf* gltf )
{
    const RfScene* scene = gltf->scene;
    char list[880] = "";
    for ( int i = 0; i < scene->loss_count; ++i )
    {
        bool fits = strlen( list ) + strlen( scene->losses[i] ) < sizeof list - 32; // and the rest
        if ( gltf->options->accept_losses )
            rf_warn( gltf->log, "%s: %s: left out", gltf->path, scene->losses[i] );
        else if ( fits || i == 0 )
            rf_append( list, sizeof list - 32, "%s%s", i > 0 ? "; " : "", scene->losses[i] );
        else
        {
            rf_append( list, sizeof list, "; and %d more", scene->loss_count - i );
            break;
        }
    }
    if ( scene->loss_count == 0 || gltf->options->accept_losses )
        return RF_OK;
    char many[48] = "";
    if ( scene->loss_count > 1 )
        snprintf( many, sizeof many, "%d textures cannot be read: ", scene->loss_count );
    rf_fail( gltf->error, gltf->lost, "%.300s: %s%s", gltf->path, many, list );
    return rf_advise( gltf->lost, RF_REMEDY_ACCEPT_LOSSES, 0, gltf->error );
}

// Float pixels are unbounded: multiplied by the factors they must remain radiance that can be
// squared.
static RfResult check_emission( RfGltf* gltf, uint32_t index )
{
    const RfMaterial* material = gltf->scene->materials + index;
    const RfTextured* t = material->textured;
    bool unlit = t->model == RF_TEXTURED_UNLIT;
    int texture = t->refs[unlit ? RF_TEXTURE_BASE : RF_TEXTURE_EMISSIVE].texture;
    if ( texture < 0 )
        return RF_OK;
    double factor = unlit ? fmax( t->factors.base[0], fmax( t->factors.base[1], t->factors.base[2] ) )
                          : (double)rf_max_component( material->emission );
    double most = factor * (double)gltf->scene->textures[texture].largest;
    if ( factor > 0.0 )
        limit_sequence( gltf, texture, RF_GLTF_MAX_EMISSION / factor );
    RfWhere where = rf_where( "materials[%u]", index );
    return rf_gltf_check_limit( gltf, where.text, "emission with its texture", most, RF_GLTF_MAX_EMISSION );
}

// An image as a texture.
typedef struct ImageSize
{
    int image, width, height;
    size_t bytes, scratch; // scratch: besides, while it is decoded
} ImageSize;

// By its header. What cannot be read has no bytes, and an error when it is decoded.
static ImageSize measure_image( RfGltf* gltf, int image )
{
    RfWhere where = rf_where( "images[%d]", image );
    Encoded encoded = { 0 };
    RfPixels header = { 0 };
    RfError none = { 0 }, *error = gltf->error; // none: what it fails with is said when it is decoded
    gltf->error = &none;
    RfResult result = read_encoded( gltf, image, where.text, &encoded );
    if ( result == RF_OK )
        result = rf_measure_image( encoded.bytes, encoded.size, where.text, &header, &none );
    gltf->error = error;
    size_t owned = encoded.owned != NULL ? encoded.size : 0;
    free( encoded.owned );
    if ( result != RF_OK )
        return ( ImageSize ){ .image = image };
    size_t pixels = rf_pixels_bytes( &header ), bytes = rf_texture_bytes( &header );
    return ( ImageSize ){ image, header.width, header.height, bytes, owned + ( bytes > pixels ? pixels : 0 ) };
}

#define NAMED 3

// Keeps the largest, in descending order.
static void keep_largest( const ImageSize* size, ImageSize largest[NAMED] )
{
    for ( int i = 0; i < NAMED; ++i )
    {
        if ( size->bytes <= largest[i].bytes )
            continue;
        memmove( largest + i + 1, largest + i, (size_t)( NAMED - 1 - i ) * sizeof *largest );
        largest[i] = *size;
        return;
    }
}

static RfResult fail_memory( const RfGltf* gltf, int count, size_t need, size_t available, const ImageSize largest[NAMED] )
{
    char list[512] = "";
    for ( int i = 0; i < NAMED && largest[i].bytes > 0; ++i )
    {
        const json_t* json = rf_gltf_item( gltf, RF_GLTF_IMAGES, largest[i].image );
        const char *name = json_string_value( json_object_get( json, "name" ) ),
                   *uri = json_string_value( json_object_get( json, "uri" ) );
        name = name == NULL && uri != NULL && !rf_is_data_uri( uri ) ? uri : name;
        size_t used = strlen( list );
        snprintf( list + used, sizeof list - used, "%s%s%s%.80s%s (%dx%d, %zu MiB)", used > 0 ? ", " : "",
                  rf_where( "images[%d]", largest[i].image ).text, name != NULL ? " '" : "", name != NULL ? name : "",
                  name != NULL ? "'" : "", largest[i].width, largest[i].height, largest[i].bytes >> 20 );
    }
    return rf_fail( gltf->error, RF_ERROR_MEMORY,
                    "%.300s: its %d textures need %zu MiB of memory, of which %zu MiB are available: scale them down, first %s",
                    gltf->path, count, need >> 20, available >> 20, list );
}

// All textures fit into the memory that is available: reported before the first is decoded.
static RfResult check_memory( RfGltf* gltf, const bool* used )
{
    const RfScene* scene = gltf->scene;
    size_t uses = 2 * ( (size_t)gltf->counts[RF_GLTF_IMAGES] + (size_t)gltf->film_count ), need = 0, scratch = 0,
           available = rf_free_memory();
    ImageSize largest[NAMED] = { { 0 } };
    int count = 0;
    bool* wanted;
    RF_TRY( rf_gltf_allocate( gltf, "images", &wanted, uses, sizeof *wanted ) );
    for ( uint32_t m = 0; m < scene->material_count; ++m )
    {
        const RfTextured* textured = scene->materials[m].textured;
        for ( int slot = 0; used[m] && textured != NULL && slot < RF_TEXTURE_SLOT_COUNT; ++slot )
        {
            if ( textured->refs[slot].texture >= 0 )
                wanted[textured->refs[slot].texture] = true;
        }
    }
    for ( size_t i = 0; i < uses; i += 2 ) // in two colour spaces: two textures
    {
        int times = wanted[i] + wanted[i + 1];
        ImageSize size = times > 0 ? measure_image( gltf, (int)i / 2 ) : ( ImageSize ){ 0 };
        count += times;
        need += (size_t)times * size.bytes + ( wanted[i + 1] ? size.bytes / 3 : 0 ); // colours have mip levels
        scratch = size.scratch > scratch ? size.scratch : scratch;
        keep_largest( &size, largest );
    }
    free( wanted );
    return need + scratch <= available ? RF_OK : fail_memory( gltf, count, need + scratch, available, largest );
}

RfResult rf_gltf_load_images( RfGltf* gltf )
{
    RfScene* scene = gltf->scene;
    size_t uses = 2 * ( (size_t)gltf->counts[RF_GLTF_IMAGES] + (size_t)gltf->film_count );
    int* numbers = malloc( ( uses + 1 ) * sizeof *numbers );
    bool* used = calloc( (size_t)scene->material_count + 1, sizeof *used );
    scene->textures = calloc( uses + 1, sizeof *scene->textures );
    RfResult result = numbers != NULL && used != NULL && scene->textures != NULL ? RF_OK : rf_gltf_no_memory( gltf, "images" );
    for ( size_t i = 0; result == RF_OK && i < uses; ++i )
        numbers[i] = UNUSED;
    if ( result == RF_OK )
        rf_mark_used_materials( scene, used );
    if ( result == RF_OK && uses > 0 )
        result = check_memory( gltf, used );
    for ( uint32_t m = 0; result == RF_OK && m < scene->material_count; ++m )
    {
        RfMaterial* material = scene->materials + m;
        if ( material->textured == NULL )
            continue;
        if ( used[m] && ( !material->textured->optional || material->textured->vertex_colors ) )
        {
            result = resolve_textures( gltf, material, numbers );
            if ( result == RF_OK )
                result = check_emission( gltf, m );
            continue;
        }
        free( material->textured ); // nothing to look up, or the images are missing
        material->textured = NULL;
    }
    free( numbers );
    free( used );
    return result == RF_OK ? tell_losses( gltf ) : result;
}

// Uses of textures by materials: texture infos, KHR_texture_transform and samplers. The image
// is only noted (gltf_texture.c decodes it later if a triangle has the material).

// Enumerants of glTF samplers, which are OpenGL's.
#define NEAREST 9728

#define LINEAR 9729
#define CLAMP 33071
#define MIRROR 33648
#define REPEAT 10497

static RfResult read_wrap( const RfField* json, const char* key, RfWrap* out )
{
    int64_t value = REPEAT;
    RF_TRY( rf_get_integer( json, key, 0, 65535, &value ) );
    if ( value != REPEAT && value != MIRROR && value != CLAMP )
        return rf_field_fail( json, "%s is %lld, it must be 10497, 33648 or 33071", key, (long long)value );
    *out = value == REPEAT ? RF_WRAP_REPEAT : value == MIRROR ? RF_WRAP_MIRROR : RF_WRAP_CLAMP;
    return RF_OK;
}

// The minification filter, which would select mipmaps, is ignored: pixels are antialiased by
// supersampling.
static RfResult read_sampler( const RfGltf* gltf, int index, RfTextureRef* out )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_SAMPLERS, index );
    int64_t filter = LINEAR;
    read_wrap( &json, "wrapS", out->wrap );
    read_wrap( &json, "wrapT", out->wrap + 1 );
    RfResult result = rf_get_integer( &json, "magFilter", 0, 65535, &filter );
    if ( result == RF_OK && filter != NEAREST && filter != LINEAR )
        return rf_field_fail( &json, "magFilter is %lld, it must be 9728 or 9729", (long long)filter );
    out->nearest = filter == NEAREST;
    return result;
}

// The image of an extension is preferred over the texture's own.
static RfResult find_image( RfGltf* gltf, const RfField* texture, int* image )
{
    static const char* const s_read[] = { "EXT_texture_webp", "EXT_texture_exr" };
    int other = -1;
    *image = rf_gltf_get_index( gltf, texture, "source", RF_GLTF_IMAGES );
    for ( size_t i = 0; other < 0 && i < sizeof s_read / sizeof s_read[0]; ++i )
    {
        RfField extension = rf_gltf_extension( texture, s_read[i] );
        if ( rf_gltf_reads( s_read[i] ) )
            other = rf_gltf_get_index( gltf, &extension, "source", RF_GLTF_IMAGES );
    }
    *image = other >= 0 ? other : *image;
    return *image < 0 && rf_json_result( texture ) == RF_OK ? rf_gltf_refuse_texture( gltf, texture ) : rf_json_result( texture );
}

// An image sequence of a scene file takes the place of the image.
static RfResult read_texture( RfGltf* gltf, int index, const RfField* film, bool srgb, RfTextureRef* out )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_TEXTURES_LIST, index );
    int image = gltf->counts[RF_GLTF_IMAGES] + gltf->film_count,
        sampler = rf_gltf_get_index( gltf, &json, "sampler", RF_GLTF_SAMPLERS );
    RF_TRY( film->json != NULL ? rf_json_result( &json ) : find_image( gltf, &json, &image ) );
    if ( film->json == NULL )
        rf_gltf_notice_extensions( gltf, &json, "texture", json.path );
    else if ( !rf_gltf_grow( &gltf->films, gltf->film_count, sizeof *gltf->films ) )
        return rf_gltf_no_memory( gltf, "images" );
    else
        gltf->films[gltf->film_count++] = *film;
    out->texture = 2 * image + srgb; // until rf_gltf_load_images
    return sampler >= 0 ? read_sampler( gltf, sampler, out ) : RF_OK;
}

// u' = T · R · S · u; the rotation is counter-clockwise as the image is seen.
// `t`: offset, rotation and scale as in the file.
static RfResult read_transform( const RfGltf* gltf, const RfField* info, int64_t* set, double t[5], RfTextureRef* out )
{
    RfField json = rf_gltf_extension( info, "KHR_texture_transform" );
    if ( json.json == NULL )
        return rf_json_result( info );
    rf_gltf_read_values( gltf, &json, RF_OF_TEXTURE, t );
    rf_get_integer( &json, "texCoord", 0, INT32_MAX, set );
    if ( rf_json_result( info ) == RF_OK )
        rf_set_uv_transform( t, out->transform );
    return rf_json_result( info );
}

// Reads a use of a texture, which its json is NULL without, with what a scene file shows instead. Until rf_gltf_load_images,
// `texture` is 2 · image + srgb.
static RfResult read_texture_info( RfGltf* gltf, const RfField* info, const RfField* film, bool srgb, double transform[5],
                                   RfTextureRef* out )
{
    const double none[5] = { 0, 0, 0, 1, 1 };
    int64_t set = 0;
    memcpy( transform, none, sizeof none );
    if ( info->json == NULL && film->json == NULL )
        return rf_json_result( info );
    if ( film->json == NULL )
        rf_gltf_require( info, "index", NULL );
    int index = rf_gltf_get_index( gltf, info, "index", RF_GLTF_TEXTURES_LIST );
    RF_TRY( rf_get_integer( info, "texCoord", 0, INT32_MAX, &set ) );
    RF_TRY( read_texture( gltf, index, film, srgb, out ) );
    RF_TRY( read_transform( gltf, info, &set, transform, out ) );
    if ( set > 1 )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, info->path,
                             "texCoord is %lld, only 0 and 1 are supported: bake it to one of these", (long long)set );
    out->uv_set = (int)set;
    return RF_OK;
}

// What makes a material vary over its surface: textures, vertex colours and alpha.

RfTextured* rf_gltf_textured( const RfFactors* factors )
{
    RfTextured* textured = calloc( 1, sizeof *textured );
    if ( textured == NULL )
        return NULL;
    textured->factors = *factors;
    textured->normal_scale = textured->clearcoat_normal_scale = 1.0f;
    for ( int i = 0; i < RF_TEXTURE_SLOT_COUNT; ++i )
        textured->refs[i] = ( RfTextureRef ){ .texture = -1, .transform = { 1, 0, 0, 0, 1, 0 } };
    return textured;
}

// The uses of textures: where they are in a material.
typedef struct Slot
{
    const char *home, *key; // home: as RfChangedTraits.home
    bool srgb;
    const char* glossy; // the key in KHR_materials_pbrSpecularGlossiness
} Slot;

static const Slot s_slots[RF_TEXTURE_SLOT_COUNT] = {
    [RF_TEXTURE_BASE] = { "pbrMetallicRoughness", "baseColorTexture", true, "diffuseTexture" },
    [RF_TEXTURE_METALLIC_ROUGHNESS] = { "pbrMetallicRoughness", "metallicRoughnessTexture", false, NULL },
    [RF_TEXTURE_NORMAL] = { NULL, "normalTexture", false, NULL },
    [RF_TEXTURE_EMISSIVE] = { NULL, "emissiveTexture", true, NULL },
    [RF_TEXTURE_SPECULAR] = { "KHR_materials_specular", "specularTexture", false, NULL },
    [RF_TEXTURE_SPECULAR_COLOR] = { "KHR_materials_specular", "specularColorTexture", true, "specularGlossinessTexture" },
    [RF_TEXTURE_TRANSMISSION] = { "KHR_materials_transmission", "transmissionTexture", false, NULL },
    [RF_TEXTURE_CLEARCOAT] = { "KHR_materials_clearcoat", "clearcoatTexture", false, NULL },
    [RF_TEXTURE_CLEARCOAT_ROUGHNESS] = { "KHR_materials_clearcoat", "clearcoatRoughnessTexture", false, NULL },
    [RF_TEXTURE_CLEARCOAT_NORMAL] = { "KHR_materials_clearcoat", "clearcoatNormalTexture", false, NULL },
    [RF_TEXTURE_SHEEN_COLOR] = { "KHR_materials_sheen", "sheenColorTexture", true, NULL },
    [RF_TEXTURE_SHEEN_ROUGHNESS] = { "KHR_materials_sheen", "sheenRoughnessTexture", false, NULL },
    [RF_TEXTURE_ANISOTROPY] = { "KHR_materials_anisotropy", "anisotropyTexture", false, NULL },
    [RF_TEXTURE_FILM] = { "KHR_materials_iridescence", "iridescenceTexture", false, NULL },
    [RF_TEXTURE_FILM_THICKNESS] = { "KHR_materials_iridescence", "iridescenceThicknessTexture", false, NULL },
    [RF_TEXTURE_THROUGH] = { "KHR_materials_diffuse_transmission", "diffuseTransmissionTexture", false, NULL },
    [RF_TEXTURE_THROUGH_COLOR] = { "KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture", true, NULL },
};

bool rf_gltf_texture_slot( const char* path, size_t length, int* slot )
{
    // what a ray tracer does without
    static const char* const s_ignored[] = { "occlusionTexture", "extensions/KHR_materials_volume/thicknessTexture" };
    for ( *slot = 0; *slot < RF_TEXTURE_SLOT_COUNT; ++*slot )
    {
        char own[RF_VALUE_PATH];
        rf_member_path( s_slots[*slot].home, s_slots[*slot].key, own );
        if ( length == strlen( own ) && strncmp( path, own, length ) == 0 )
            return true;
    }
    *slot = -1;
    for ( int i = 0; i < 2; ++i )
    {
        if ( length == strlen( s_ignored[i] ) && strncmp( path, s_ignored[i], length ) == 0 )
            return true;
    }
    return false;
}

// The use of a texture in the document. KHR_materials_pbrSpecularGlossiness has its own in the place of some.
static RfField find_use( const RfGltfMaterial* m, RfTextureSlot slot )
{
    const Slot* traits = s_slots + slot;
    bool glossy = m->glossiness.json != NULL && slot <= RF_TEXTURE_SPECULAR_COLOR && traits->home != NULL;
    const char* key = glossy ? traits->glossy : traits->key;
    RfField home = glossy ? m->glossiness : rf_gltf_home( &m->json, traits->home );
    return key != NULL && m->textures ? rf_get_object( &home, key ) : rf_make_field( home.file, "", NULL, home.error );
}

bool rf_gltf_has_texture( const RfGltfMaterial* m, RfTextureSlot slot )
{
    return find_use( m, slot ).json != NULL || rf_has_member( &m->edit, s_slots[slot].key );
}

static RfResult read_slots( RfGltf* gltf, const RfGltfMaterial* m, double transforms[][5], RfTextured* out )
{
    double scale[RF_TEXTURE_SLOT_COUNT];
    for ( int slot = 0; slot < RF_TEXTURE_SLOT_COUNT; ++slot )
    {
        RfField info = find_use( m, (RfTextureSlot)slot ), film = rf_field_member( &m->edit, s_slots[slot].key );
        scale[slot] = 1.0;
        if ( info.json == NULL && film.json == NULL )
            continue;
        RfResult result = read_texture_info( gltf, &info, &film, s_slots[slot].srgb, transforms[slot], out->refs + slot );
        if ( result == RF_OK && ( slot == RF_TEXTURE_NORMAL || slot == RF_TEXTURE_CLEARCOAT_NORMAL ) )
            result = rf_get_number( &info, "scale", rf_any_number(), scale + slot );
        if ( result != RF_OK )
            return result;
    }
    out->normal_scale = (float)scale[RF_TEXTURE_NORMAL];
    out->clearcoat_normal_scale = (float)scale[RF_TEXTURE_CLEARCOAT_NORMAL];
    return rf_json_result( &m->json );
}

// The thickness texture is for rasterisers. It is validated but otherwise ignored: a ray
// tracer finds the thickness itself.
static RfResult check_thickness( RfGltf* gltf, const RfGltfMaterial* m )
{
    RfTextureRef unused;
    double transform[5];
    RfField volume = rf_gltf_extension( &m->json, "KHR_materials_volume" ), info = rf_get_object( &volume, "thicknessTexture" ),
            none = rf_make_field( "", "", NULL, gltf->error );
    return m->textures ? read_texture_info( gltf, &info, &none, false, transform, &unused ) : rf_json_result( &m->json );
}

static void drop_slots( RfTextured* textured, RfTextureSlot first, RfTextureSlot last )
{
    for ( int slot = (int)first; slot <= (int)last; ++slot )
        textured->refs[slot].texture = -1;
}

// Drops textures of features that the material turned out not to have.
static void drop_unused( const RfMaterial* m, RfTextured* textured )
{
    RfBsdfParams params = rf_bsdf_model( m->kind )->params;
    if ( textured->model != RF_TEXTURED_GLASS || m->ior == 0.0f )
        drop_slots( textured, RF_TEXTURE_TRANSMISSION, RF_TEXTURE_TRANSMISSION );
    if ( !rf_has_param( params, RF_PARAM_CLEARCOAT ) || m->clearcoat == 0.0f )
        drop_slots( textured, RF_TEXTURE_CLEARCOAT, RF_TEXTURE_CLEARCOAT_NORMAL );
    if ( !rf_has_param( params, RF_PARAM_SHEEN ) || rf_max_component( m->sheen ) == 0.0f )
        drop_slots( textured, RF_TEXTURE_SHEEN_COLOR, RF_TEXTURE_SHEEN_ROUGHNESS );
    if ( !rf_has_param( params, RF_PARAM_ANISOTROPY ) || m->anisotropy == 0.0f )
        drop_slots( textured, RF_TEXTURE_ANISOTROPY, RF_TEXTURE_ANISOTROPY );
    if ( !rf_has_param( params, RF_PARAM_FILM ) || m->film == 0.0f )
        drop_slots( textured, RF_TEXTURE_FILM, RF_TEXTURE_FILM_THICKNESS );
    if ( m->kind != RF_BSDF_TRANSLUCENT )
        drop_slots( textured, RF_TEXTURE_THROUGH, RF_TEXTURE_THROUGH_COLOR );
}

static RfResult read_alpha( const RfGltfMaterial* m, double cutoff, RfTextured* out )
{
    static const char* const s_modes[] = { "OPAQUE", "MASK", "BLEND", NULL };
    int mode = 0;
    rf_get_choice( &m->json, "alphaMode", s_modes, &mode );
    rf_get_choice( &m->edit, "alphaMode", s_modes, &mode );
    out->masked = mode == 1;
    out->blended = mode == 2;
    out->alpha_cutoff = mode != 0 ? (float)cutoff : 0.0f;
    return rf_json_result( &m->json );
}

static RfTexturedModel find_model( const RfGltfMaterial* m, const RfMaterial* out )
{
    if ( m->model != NULL )
        return RF_TEXTURED_DIFFUSE;
    if ( m->unlit )
        return RF_TEXTURED_UNLIT;
    return out->kind >= RF_BSDF_FIRST_SPECULAR ? RF_TEXTURED_GLASS : RF_TEXTURED_COATED;
}

// Do its textures show other images at other times?
static RfResult find_sequences( RfGltf* gltf, RfMaterial* out )
{
    for ( int slot = 0; slot < RF_TEXTURE_SLOT_COUNT; ++slot )
    {
        bool plays = false;
        if ( out->textured->refs[slot].texture >= 0 )
            RF_TRY( does_play( gltf, out->textured->refs[slot].texture / 2, &plays ) );
        out->changes = out->changes || plays;
        gltf->plays = gltf->plays || plays;
    }
    return RF_OK;
}

// A metal that is a perfect mirror by its factors is not one if a texture sets its roughness.
static void undo_mirror( const RfTextured* textured, RfMaterial* out )
{
    if ( out->kind >= RF_BSDF_FIRST_SPECULAR && out->ior == 0.0f && textured->refs[RF_TEXTURE_METALLIC_ROUGHNESS].texture >= 0 )
    {
        rf_derive_lobes( &textured->factors, out );
        out->kind = textured->factors.through > 0.0 ? RF_BSDF_TRANSLUCENT
                    : out->kind == RF_BSDF_SPECTRAL ? RF_BSDF_IRIDESCENT
                                                    : RF_BSDF_GGX;
    }
}

// True if anything varies or depends on alpha.
static bool is_needed( const RfTextured* textured )
{
    for ( int i = 0; i < RF_TEXTURE_SLOT_COUNT; ++i )
    {
        if ( textured->refs[i].texture >= 0 )
            return true;
    }
    double alpha = textured->factors.base[3];
    return ( textured->masked && alpha < (double)textured->alpha_cutoff ) || ( textured->blended && alpha < 1.0 );
}

RfResult rf_gltf_read_textured( RfGltf* gltf, const RfGltfMaterial* m, RfMovingMaterial* moving, RfMaterial* out )
{
    const RfMaterialValues* values = &moving->values;
    out->textured = rf_gltf_textured( &values->lobes );
    if ( out->textured == NULL )
        return rf_field_no_memory( &m->json );
    RfTextured* textured = out->textured;
    RF_TRY( read_slots( gltf, m, moving->transform, textured ) );
    RF_TRY( check_thickness( gltf, m ) );
    RF_TRY( read_alpha( m, values->alpha_cutoff, textured ) );
    undo_mirror( textured, out );
    textured->model = find_model( m, out );
    // our own models vary their own diffuse reflectance
    if ( textured->model == RF_TEXTURED_DIFFUSE )
        textured->factors.base[0] = textured->factors.base[1] = textured->factors.base[2] = 1.0;
    textured->transmission = values->transmission;
    textured->clearcoat = values->clearcoat;
    textured->clearcoat_roughness = values->clearcoat_roughness;
    drop_unused( out, textured );
    textured->glossy = m->glossiness.json != NULL && textured->refs[RF_TEXTURE_SPECULAR_COLOR].texture >= 0;
    textured->optional = !is_needed( textured );
    return find_sequences( gltf, out );
}
