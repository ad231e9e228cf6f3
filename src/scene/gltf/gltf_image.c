// Images: decodes those that materials of triangles use, once per colour space in which they
// are used.

#include "scene/gltf/gltf_materials.h"

#include "base/file.h"
#include "image/decode.h"
#include "scene/textured.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Limit of one image file.
#define MAX_IMAGE_BYTES ( (uint64_t)1 << 30 )

// An encoded image.
typedef struct Encoded
{
    const uint8_t* bytes;
    size_t size;
    uint8_t* owned;
} Encoded;

static RfResult read_uri( RfGltf* gltf, const char* where, const char* uri, Encoded* out )
{
    if ( rf_is_data_uri( uri ) )
        return rf_gltf_decode_data_uri( gltf, where, uri, &out->owned, &out->size );
    char* path;
    RfResult result = rf_gltf_resolve_uri( gltf, where, uri, &path );
    if ( result != RF_OK )
        return result;
    RfError error;
    result = rf_read_file( path, MAX_IMAGE_BYTES, &out->owned, &out->size, &error );
    free( path );
    if ( result != RF_OK )
        return rf_gltf_fail( gltf, result, where, "%.560s", error.text );
    gltf->scene->content_hash = rf_hash_bytes( gltf->scene->content_hash, out->owned, out->size );
    return RF_OK;
}

static RfResult read_view( const RfGltf* gltf, const char* where, int view, Encoded* out )
{
    RfWhere self = rf_where( "bufferViews[%d]", view );
    int64_t length = 0;
    RfResult result = rf_gltf_get_integer( gltf, rf_gltf_item( gltf, RF_GLTF_BUFFER_VIEWS, view ), self.text, "byteLength", 1,
                                           INT64_MAX, &length );
    if ( result == RF_OK )
        result = rf_gltf_view_bytes( gltf, where, view, 0, (uint64_t)length, &out->bytes );
    out->size = (size_t)length;
    return result;
}

static RfResult read_encoded( RfGltf* gltf, int index, const char* where, Encoded* out )
{
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_IMAGES, index );
    const char* uri = NULL;
    int view;
    RfResult result = rf_gltf_get_string( gltf, json, where, "uri", &uri );
    if ( result == RF_OK )
        result = rf_gltf_get_index( gltf, json, where, "bufferView", RF_GLTF_BUFFER_VIEWS, &view );
    if ( result != RF_OK )
        return result;
    if ( ( uri != NULL ) == ( view >= 0 ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "wants either uri or bufferView" );
    result = uri != NULL ? read_uri( gltf, where, uri, out ) : read_view( gltf, where, view, out );
    out->bytes = out->owned != NULL ? out->owned : out->bytes;
    return result;
}

static size_t value_count( const RfTexture* t ) { return (size_t)t->width * (size_t)t->height * (size_t)t->channels; }

static bool is_alpha( const RfTexture* t, size_t i )
{
    size_t channels = (size_t)t->channels;
    return channels % 2 == 0 && i % channels == channels - 1;
}

// Converts 16-bit pixels to floats.
static RfResult widen( const RfGltf* gltf, const char* where, const RfPixels* pixels, bool srgb, RfTexture* out )
{
    size_t count = value_count( out );
    const uint16_t* from = pixels->data;
    out->floats = malloc( count * sizeof *out->floats );
    if ( out->floats == NULL )
        return rf_gltf_no_memory( gltf, where );
    for ( size_t i = 0; i < count; ++i )
    {
        float value = (float)from[i] / 65535.0f;
        out->floats[i] = srgb && !is_alpha( out, i ) ? rf_srgb_to_linear( value ) : value;
    }
    return RF_OK;
}

static RfResult take_floats( const RfGltf* gltf, const char* where, RfPixels* pixels, RfTexture* out )
{
    size_t count = value_count( out ), channels = (size_t)out->channels, width = (size_t)out->width;
    out->floats = pixels->data;
    pixels->data = NULL;
    for ( size_t i = 0; i < count; ++i )
    {
        if ( !isfinite( out->floats[i] ) )
            return rf_gltf_fail( gltf, RF_ERROR_SCENE, where, "pixel (%zu, %zu) is not finite: repair the image",
                                 i / channels % width, i / channels / width );
        out->floats[i] = fmaxf( out->floats[i], 0.0f );
    }
    return RF_OK;
}

static void find_largest( RfTexture* t )
{
    size_t count = value_count( t );
    for ( size_t i = 0; i < count; ++i )
    {
        if ( !is_alpha( t, i ) )
            t->largest = fmaxf( t->largest, t->bytes != NULL ? t->table[t->bytes[i]] : t->floats[i] );
    }
}

static RfResult make_texture( const RfGltf* gltf, const char* where, RfPixels* pixels, bool srgb, RfTexture* out )
{
    out->width = pixels->width;
    out->height = pixels->height;
    out->channels = pixels->channels;
    for ( int i = 0; i < 256; ++i )
        out->table[i] = srgb ? rf_srgb_to_linear( (float)i / 255.0f ) : (float)i / 255.0f;
    RfResult result = RF_OK;
    if ( pixels->type == RF_PIXELS_U8 )
    {
        out->bytes = pixels->data;
        pixels->data = NULL;
    }
    else
        result =
            pixels->type == RF_PIXELS_U16 ? widen( gltf, where, pixels, srgb, out ) : take_floats( gltf, where, pixels, out );
    if ( result == RF_OK )
        find_largest( out );
    return result;
}

static RfResult load_image( RfGltf* gltf, int index, bool srgb, RfTexture* out )
{
    RfWhere where = rf_where( "images[%d]", index );
    Encoded encoded = { 0 };
    RfPixels pixels = { 0 };
    RfError error;
    RfResult result = read_encoded( gltf, index, where.text, &encoded );
    if ( result == RF_OK )
    {
        result = rf_decode_image( encoded.bytes, encoded.size, where.text, &pixels, &error );
        // the message begins with `where`
        if ( result != RF_OK )
            rf_fail( gltf->error, result, "%s: %s", gltf->path, error.text );
    }
    free( encoded.owned );
    if ( result == RF_OK )
        result = make_texture( gltf, where.text, &pixels, srgb, out );
    rf_destroy_pixels( &pixels );
    return result;
}

// `numbers` maps each image and colour space to a texture index, −1 before its first use.
static RfResult resolve_textures( RfGltf* gltf, RfMaterial* material, int* numbers )
{
    RfScene* scene = gltf->scene;
    for ( int slot = 0; slot < RF_TEXTURE_SLOT_COUNT; ++slot )
    {
        int* use = &material->textured->refs[slot].texture;
        if ( *use < 0 )
            continue;
        if ( numbers[*use] < 0 )
        {
            numbers[*use] = scene->texture_count++;
            RfResult result = load_image( gltf, *use / 2, *use % 2 == 1, scene->textures + numbers[*use] );
            if ( result != RF_OK )
                return result;
        }
        *use = numbers[*use];
    }
    return RF_OK;
}

// Float pixels are unbounded: multiplied by the factors they must remain radiance that can be
// squared.
static RfResult check_emission( const RfGltf* gltf, uint32_t index )
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
    RfWhere where = rf_where( "materials[%u]", index );
    return rf_gltf_check_limit( gltf, where.text, "emission with its texture", most, RF_GLTF_MAX_EMISSION );
}

RfResult rf_gltf_load_images( RfGltf* gltf )
{
    RfScene* scene = gltf->scene;
    size_t uses = 2 * (size_t)gltf->counts[RF_GLTF_IMAGES];
    int* numbers = malloc( ( uses + 1 ) * sizeof *numbers );
    bool* used = calloc( (size_t)scene->material_count + 1, sizeof *used );
    scene->textures = calloc( uses + 1, sizeof *scene->textures );
    RfResult result = numbers != NULL && used != NULL && scene->textures != NULL ? RF_OK : rf_gltf_no_memory( gltf, "images" );
    for ( size_t i = 0; result == RF_OK && i < uses; ++i )
        numbers[i] = -1;
    for ( uint32_t i = 0; result == RF_OK && i < scene->triangles.count; ++i )
        used[scene->triangles.material[i]] = true;
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
    return result;
}
