// Uses of textures by materials: texture infos, KHR_texture_transform and samplers. The image
// is only noted (gltf_image.c decodes it later if a triangle has the material).

#include "scene/gltf/gltf_materials.h"

#include <math.h>

// Enumerants of glTF samplers, which are OpenGL's.
#define NEAREST 9728
#define LINEAR 9729
#define CLAMP 33071
#define MIRROR 33648
#define REPEAT 10497

// Larger scales of coordinates leave no precision.
#define MAX_TRANSFORM 1e6

static RfResult read_wrap( const RfGltf* gltf, const json_t* json, const char* where, const char* key, RfWrap* out )
{
    int64_t value = REPEAT;
    RfResult result = rf_gltf_get_integer( gltf, json, where, key, 0, 65535, &value );
    if ( result != RF_OK )
        return result;
    if ( value != REPEAT && value != MIRROR && value != CLAMP )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s is %lld, it wants 10497, 33648 or 33071", key, (long long)value );
    *out = value == REPEAT ? RF_WRAP_REPEAT : value == MIRROR ? RF_WRAP_MIRROR : RF_WRAP_CLAMP;
    return RF_OK;
}

// The minification filter, which would select mipmaps, is ignored: pixels are antialiased by
// supersampling.
static RfResult read_sampler( const RfGltf* gltf, int index, RfTextureRef* out )
{
    RfWhere where = rf_where( "samplers[%d]", index );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_SAMPLERS, index );
    int64_t filter = LINEAR;
    RfResult result = read_wrap( gltf, json, where.text, "wrapS", out->wrap );
    if ( result == RF_OK )
        result = read_wrap( gltf, json, where.text, "wrapT", out->wrap + 1 );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, json, where.text, "magFilter", 0, 65535, &filter );
    if ( result == RF_OK && filter != NEAREST && filter != LINEAR )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where.text, "magFilter is %lld, it wants 9728 or 9729", (long long)filter );
    out->nearest = filter == NEAREST;
    return result;
}

static RfResult read_texture( const RfGltf* gltf, int index, bool srgb, RfTextureRef* out )
{
    RfWhere where = rf_where( "textures[%d]", index );
    const json_t* json = rf_gltf_item( gltf, RF_GLTF_TEXTURES_LIST, index );
    int sampler, image;
    RfResult result = rf_gltf_get_index( gltf, json, where.text, "sampler", RF_GLTF_SAMPLERS, &sampler );
    if ( result == RF_OK )
        result = rf_gltf_get_index( gltf, json, where.text, "source", RF_GLTF_IMAGES, &image );
    if ( result != RF_OK )
        return result;
    if ( image < 0 )
        return rf_gltf_fail(
            gltf, RF_ERROR_UNSUPPORTED, where.text,
            "has no PNG or JPEG as its source: convert the images, as by `npx @gltf-transform/cli png in.glb out.glb`" );
    out->texture = 2 * image + srgb; // until rf_gltf_load_images
    return sampler >= 0 ? read_sampler( gltf, sampler, out ) : RF_OK;
}

// u' = T · R · S · u; the rotation is counter-clockwise as the image is seen.
static RfResult read_transform( const RfGltf* gltf, const json_t* info, const char* owner, int64_t* set, RfTextureRef* out )
{
    const json_t* json;
    double offset[2] = { 0, 0 }, scale[2] = { 1, 1 }, rotation = 0.0;
    RfResult result = rf_gltf_get_extension( gltf, info, owner, "KHR_texture_transform", &json );
    if ( result != RF_OK || json == NULL )
        return result;
    RfWhere where = rf_where( "%s.extensions.KHR_texture_transform", owner );
    result = rf_gltf_get_numbers( gltf, json, where.text, "offset", 2, offset );
    if ( result == RF_OK )
        result = rf_gltf_get_numbers( gltf, json, where.text, "scale", 2, scale );
    if ( result == RF_OK )
        result = rf_gltf_get_number( gltf, json, where.text, "rotation", &rotation );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, json, where.text, "texCoord", 0, INT32_MAX, set );
    if ( result != RF_OK )
        return result;
    double t[6] = { cos( rotation ) * scale[0],  sin( rotation ) * scale[1], offset[0],
                    -sin( rotation ) * scale[0], cos( rotation ) * scale[1], offset[1] };
    for ( int i = 0; i < 6; ++i )
    {
        result = rf_gltf_check_limit( gltf, where.text, i % 3 == 2 ? "offset" : "scale", t[i], MAX_TRANSFORM );
        if ( result != RF_OK )
            return result;
        out->transform[i] = (float)t[i];
    }
    return RF_OK;
}

RfResult rf_gltf_read_texture_info( RfGltf* gltf, const json_t* parent, const char* owner, const char* key, bool srgb,
                                    RfTextureRef* out, const json_t** info )
{
    *info = NULL;
    RfResult result = rf_gltf_get_object( gltf, parent, owner, key, info );
    if ( result != RF_OK || *info == NULL )
        return result;
    RfWhere where = rf_where( "%s.%s", owner, key );
    int index;
    int64_t set = 0;
    result = rf_gltf_require( gltf, *info, where.text, "index" );
    if ( result == RF_OK )
        result = rf_gltf_get_index( gltf, *info, where.text, "index", RF_GLTF_TEXTURES_LIST, &index );
    if ( result == RF_OK )
        result = rf_gltf_get_integer( gltf, *info, where.text, "texCoord", 0, INT32_MAX, &set );
    if ( result == RF_OK )
        result = read_texture( gltf, index, srgb, out );
    if ( result == RF_OK )
        result = read_transform( gltf, *info, where.text, &set, out );
    if ( result == RF_OK && set > 1 )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where.text,
                             "texCoord is %lld, only 0 and 1 are supported: bake it to one of these", (long long)set );
    out->uv_set = (int)set;
    return result;
}
