// KHR_animation_pointer: what a channel animates, as a path in the document. The templates are those of glTF's object model.
#include "scene/gltf/gltf_changes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LIGHTS "extensions/KHR_lights_punctual/lights"

// A list of the document whose items have values that change.
typedef struct List
{
    const char *name, *item; // item: in words
    int list;                // RfGltfList, or −1: punctual lights
} List;

static const List s_lists[] = { { "nodes", "node", RF_GLTF_NODES },       { "materials", "material", RF_GLTF_MATERIALS },
                                { "cameras", "camera", RF_GLTF_CAMERAS }, { LIGHTS, "light", -1 },
                                { "meshes", "mesh", RF_GLTF_MESHES },     { "textures", "texture", RF_GLTF_TEXTURES_LIST } };

// A pointer taken apart.
typedef struct Pointer
{
    const List* list; // NULL: none that is known
    int index;
    const char* member; // what follows "/materials/7/"
} Pointer;

static const json_t* lights_of( const RfGltf* gltf )
{
    return json_object_get( json_object_get( json_object_get( gltf->root, "extensions" ), "KHR_lights_punctual" ), "lights" );
}

static int count_of( const RfGltf* gltf, const List* list )
{
    return list->list >= 0 ? gltf->counts[list->list] : (int)json_array_size( lights_of( gltf ) );
}

static RfResult take_apart( const RfGltf* gltf, const char* pointer, const char* where, Pointer* out )
{
    *out = ( Pointer ){ 0 };
    for ( size_t i = 0; i < sizeof s_lists / sizeof s_lists[0]; ++i )
    {
        const List* list = s_lists + i;
        size_t length = strlen( list->name );
        long long index = -1;
        int digits = 0;
        if ( pointer[0] != '/' || strncmp( pointer + 1, list->name, length ) != 0 ||
             sscanf( pointer + 1 + length, "/%9lld/%n", &index, &digits ) != 1 || digits == 0 )
            continue;
        if ( index < 0 || index >= count_of( gltf, list ) )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "pointer '%.80s' names a %s that does not exist", pointer,
                                 list->item );
        *out = ( Pointer ){ list, (int)index, pointer + 1 + length + digits };
        return RF_OK;
    }
    return RF_OK;
}

// What a pointer names, in words.
static RfWhere name_target( const RfGltf* gltf, const char* pointer, const Pointer* parts )
{
    if ( parts->list == NULL )
        return rf_where( "%.100s", pointer[0] != '\0' ? pointer : "animations" );
    const json_t* item = parts->list->list >= 0 ? rf_gltf_item( gltf, (RfGltfList)parts->list->list, parts->index )
                                                : json_array_get( lights_of( gltf ), (size_t)parts->index );
    const char* name = json_string_value( json_object_get( item, "name" ) );
    return name != NULL && name[0] != 0 ? rf_where( "%s '%.80s'", parts->list->item, name )
                                        : rf_where( "%s %d", parts->list->item, parts->index );
}

// A value that is read. Of IGNORED ones nothing is read when they stand still, either.
typedef struct Member
{
    const char* path;
    int value; // RfChangedValue or IGNORED
} Member;

#define IGNORED ( -1 )

static const Member s_of_lights[] = { { "intensity", RF_CHANGED_INTENSITY },
                                      { "color", RF_CHANGED_COLOR },
                                      { "range", RF_CHANGED_RANGE },
                                      { "spot/innerConeAngle", RF_CHANGED_INNER_CONE },
                                      { "spot/outerConeAngle", RF_CHANGED_OUTER_CONE },
                                      { NULL, 0 } };

static const Member s_of_materials[] = { { "pbrMetallicRoughness/baseColorFactor", RF_CHANGED_BASE_COLOR },
                                         { "pbrMetallicRoughness/metallicFactor", RF_CHANGED_METALLIC },
                                         { "pbrMetallicRoughness/roughnessFactor", RF_CHANGED_ROUGHNESS },
                                         { "emissiveFactor", RF_CHANGED_EMISSIVE },
                                         { "extensions/KHR_materials_emissive_strength/emissiveStrength",
                                           RF_CHANGED_EMISSIVE_STRENGTH },
                                         { "occlusionTexture/strength", IGNORED },
                                         { NULL, 0 } };

static const Member s_of_textures[] = { { "offset", RF_CHANGED_TEXTURE_OFFSET },
                                        { "rotation", RF_CHANGED_TEXTURE_ROTATION },
                                        { "scale", RF_CHANGED_TEXTURE_SCALE },
                                        { NULL, 0 } };

// The width of a picture follows from its shape.
static const Member s_of_cameras[] = {
    { "perspective/yfov", RF_CHANGED_YFOV }, { "orthographic/ymag", RF_CHANGED_YMAG }, { "perspective/aspectRatio", IGNORED },
    { "perspective/znear", IGNORED },        { "perspective/zfar", IGNORED },          { "orthographic/xmag", IGNORED },
    { "orthographic/znear", IGNORED },       { "orthographic/zfar", IGNORED },         { NULL, 0 }
};

static const Member* find_member( const Member* members, const char* path )
{
    for ( ; members->path != NULL; ++members )
    {
        if ( strcmp( members->path, path ) == 0 )
            return members;
    }
    return NULL;
}

// ".../extensions/KHR_texture_transform/scale". Textures that are ignored have the slot −1.
static const Member* find_transform( const char* path, int* slot )
{
    static const char* const s_extension = "/extensions/KHR_texture_transform/";
    const char* after = strstr( path, s_extension );
    if ( after == NULL || !rf_gltf_texture_slot( path, (size_t)( after - path ), slot ) )
        return NULL;
    return find_member( s_of_textures, after + strlen( s_extension ) );
}

static void take_member( const Member* member, const Pointer* parts, RfGltfTarget* out )
{
    if ( member == NULL )
        return;
    out->unrendered = NULL;
    out->wanted = member->value != IGNORED && out->change.slot >= 0;
    if ( !out->wanted )
        return;
    out->change.value = (RfChangedValue)member->value;
    out->change.of = parts->index;
    out->change.channel.path = RF_VALUE;
    out->change.channel.components = rf_changed_traits( out->change.value )->components;
}

static void follow_to_node( const Pointer* parts, RfGltfTarget* out )
{
    static const char* const s_members[] = { "translation", "rotation", "scale", "weights",
                                             "extensions/KHR_node_visibility/visible" };
    for ( int i = 0; i < 5; ++i )
    {
        if ( strcmp( parts->member, s_members[i] ) != 0 )
            continue;
        out->change.channel.node = parts->index;
        out->change.channel.path = (RfAnimatedPath)i;
        out->wanted = true;
        out->unrendered = NULL;
    }
}

static void follow( const Pointer* parts, RfGltfTarget* out )
{
    if ( parts->list->list == RF_GLTF_NODES )
        follow_to_node( parts, out );
    else if ( parts->list->list == -1 )
        take_member( find_member( s_of_lights, parts->member ), parts, out );
    else if ( parts->list->list == RF_GLTF_CAMERAS )
        take_member( find_member( s_of_cameras, parts->member ), parts, out );
    else if ( parts->list->list == RF_GLTF_MATERIALS )
    {
        const Member* member = find_member( s_of_materials, parts->member );
        take_member( member != NULL ? member : find_transform( parts->member, &out->change.slot ), parts, out );
    }
}

RfResult rf_gltf_follow_pointer( RfGltf* gltf, const RfField* target, const char* where, RfGltfTarget* out )
{
    const char* pointer = "";
    Pointer parts;
    RfField extension = rf_gltf_extension( target, "KHR_animation_pointer" );
    if ( extension.json == NULL )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "target.extensions.KHR_animation_pointer is missing" );
    rf_gltf_require( &extension, "pointer", NULL );
    RfResult result = rf_get_text( &extension, "pointer", &pointer );
    if ( result == RF_OK )
        result = take_apart( gltf, pointer, where, &parts );
    if ( result != RF_OK )
        return result;
    out->unrendered = pointer;
    if ( parts.list != NULL )
        follow( &parts, out );
    return RF_OK;
}

RfResult rf_gltf_note_pointer( RfGltf* gltf, const char* pointer )
{
    Pointer parts;
    RfResult result = take_apart( gltf, pointer, "animations", &parts );
    if ( result != RF_OK )
        return result;
    RfWhere what = name_target( gltf, pointer, &parts );
    return rf_gltf_note_unrendered( gltf, what.text, "the file animates '%.160s', which is not rendered", pointer );
}
