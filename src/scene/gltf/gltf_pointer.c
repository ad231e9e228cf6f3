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

// What changes no picture: occlusion, clipping planes, and the width of a picture, which follows from its shape.
static const char* const s_ignored[] = { "occlusionTexture/strength", "perspective/aspectRatio", "perspective/znear",
                                         "perspective/zfar",          "orthographic/xmag",       "orthographic/znear",
                                         "orthographic/zfar" };

static bool is_ignored( const char* path )
{
    bool found = false;
    for ( size_t i = 0; i < sizeof s_ignored / sizeof s_ignored[0]; ++i )
        found = found || strcmp( s_ignored[i], path ) == 0;
    return found;
}

// The value of an owner that has a path and may change, or RF_CHANGED_COUNT.
static RfChangedValue find_value( RfValueOwner owner, const char* path )
{
    RfChangedValue v = rf_next_value( owner, 0 );
    for ( ; v < RF_CHANGED_COUNT; v = rf_next_value( owner, (int)v + 1 ) )
    {
        char own[RF_VALUE_PATH];
        rf_member_path( rf_changed_traits( v )->home, rf_changed_traits( v )->name, own );
        if ( ( rf_changed_traits( v )->flags & RF_VALUE_ANIMATED ) != 0 && strcmp( own, path ) == 0 )
            break;
    }
    return v;
}

// ".../extensions/KHR_texture_transform/scale". Textures that are ignored have the slot −1.
static RfChangedValue find_transform( const char* path, int* slot )
{
    static const char* const s_extension = "/extensions/KHR_texture_transform/";
    const char* after = strstr( path, s_extension );
    if ( after == NULL || !rf_gltf_texture_slot( path, (size_t)( after - path ), slot ) )
        return RF_CHANGED_COUNT;
    return find_value( RF_OF_TEXTURE, after + strlen( s_extension ) );
}

static void follow_to_value( RfValueOwner owner, const Pointer* parts, RfGltfTarget* out )
{
    RfChangedValue value = find_value( owner, parts->member );
    if ( value == RF_CHANGED_COUNT && owner == RF_OF_MATERIAL )
        value = find_transform( parts->member, &out->change.slot );
    bool known = value < RF_CHANGED_COUNT;
    if ( !known && !is_ignored( parts->member ) )
        return;
    out->unrendered = NULL;
    out->wanted = known && out->change.slot >= 0;
    if ( !out->wanted )
        return;
    out->change.value = value;
    out->change.of = parts->index;
    out->change.channel.path = RF_VALUE;
    out->change.channel.components = rf_changed_traits( value )->components;
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
        follow_to_value( RF_OF_LAMP, parts, out );
    else if ( parts->list->list == RF_GLTF_CAMERAS )
        follow_to_value( RF_OF_CAMERA, parts, out );
    else if ( parts->list->list == RF_GLTF_MATERIALS )
        follow_to_value( RF_OF_MATERIAL, parts, out );
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
