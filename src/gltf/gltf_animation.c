// Animations: the channels of all of them merged into one list sorted by node, and the time
// span in which each node moves.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Numbers in all channels, 1 GiB: channels may share samplers, so a small file could otherwise
// request any amount.
#define MAX_VALUES ( (uint64_t)1 << 27 )

#define GIVEN INT_MAX // in the place of an animation: from outside the file

typedef struct Loader
{
    uint64_t values;
    json_t* owners; // by name_change: which animation animates it, or GIVEN
    int* left_out;  // animations that move what one before them moves
    int left_out_count;
    int instead; // of the first of those
} Loader;

#define MAX_NAMED 5 // in a warning

static RfResult read_times( RfGltf* gltf, int index, const char* where, RfChannel* channel )
{
    const RfGltfAccessor* accessor = gltf->accessors + index;
    RF_TRY( rf_gltf_allocate( gltf, where, &channel->times, (size_t)channel->count, sizeof *channel->times ) );
    if ( accessor->component_type != 5126 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "input accessors[%d] must be floats", index );
    double last = -1.0;
    for ( int i = 0; i < channel->count; ++i )
    {
        float time;
        RF_TRY( rf_gltf_read_floats( gltf, index, (uint32_t)i, &time ) );
        if ( time < 0.0f || (double)time <= last )
            return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where,
                                 "input accessors[%d], key %d is at %g s: times must be at "
                                 "least 0 and increase",
                                 index, i, (double)time );
        last = channel->times[i] = (double)time;
    }
    return RF_OK;
}

static RfResult check_rotation( const RfGltf* gltf, const char* where, const RfChannel* channel, int element, double* q )
{
    // tangents are not unit quaternions
    if ( channel->path != RF_ROTATION || ( channel->interpolation == RF_CUBICSPLINE && element % 3 != 1 ) )
        return RF_OK;
    double length = sqrt( q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] );
    if ( ( length > 1e-6 && length < 1e6 ) == false )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "output %d is not a unit quaternion", element );
    // the tangents of a spline belong to unnormalised values: it is normalised after interpolation
    for ( int i = 0; i < 4 && channel->interpolation != RF_CUBICSPLINE; ++i )
        q[i] /= length;
    return RF_OK;
}

static RfResult read_values( RfGltf* gltf, int index, const char* where, RfChannel* channel )
{
    const RfGltfAccessor* accessor = gltf->accessors + index;
    int per_key = channel->interpolation == RF_CUBICSPLINE ? 3 : 1;
    int components = channel->components;
    int64_t elements = (int64_t)channel->count * per_key;
    if ( channel->path == RF_WEIGHTS ) // each is an element
    {
        elements *= components;
        components = 1;
    }
    RF_TRY( rf_gltf_expect( gltf, index, accessor, where, components ) );
    if ( accessor->count != elements )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "output accessors[%d] has %u elements, %lld are needed", index,
                             accessor->count, (long long)elements );
    RF_TRY( rf_gltf_allocate( gltf, where, &channel->values, (size_t)elements * (size_t)components, sizeof *channel->values ) );
    for ( int i = 0; i < elements; ++i )
    {
        float value[4];
        double* out = channel->values + (size_t)i * (size_t)components;
        RF_TRY( rf_gltf_read_floats( gltf, index, (uint32_t)i, value ) );
        for ( int c = 0; c < components; ++c )
            out[c] = (double)value[c];
        RF_TRY( check_rotation( gltf, where, channel, i, out ) );
    }
    return RF_OK;
}

// Truth has nothing between its values.
static RfResult check_visibility( const RfGltf* gltf, const char* where, RfChannel* channel )
{
    if ( channel->path != RF_VISIBILITY )
        return RF_OK;
    if ( channel->interpolation != RF_STEP )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "shows and hides nodes[%d], whose interpolation must be STEP",
                             channel->node );
    for ( int i = 0; i < channel->count; ++i )
        channel->values[i] = channel->values[i] != 0.0 ? 1.0 : 0.0;
    return RF_OK;
}

static RfResult read_sampler( RfGltf* gltf, Loader* loader, const RfField* json, RfChannel* channel )
{
    static const char* const s_interpolations[] = { "STEP", "LINEAR", "CUBICSPLINE", NULL };
    const RfGltfAccessor *times = NULL, *values = NULL;
    int interpolation = RF_LINEAR;
    const char* where = json->path;
    rf_get_choice( json, "interpolation", s_interpolations, &interpolation );
    channel->interpolation = (RfInterpolation)interpolation;
    rf_gltf_require( json, "input", "output", NULL );
    int input = rf_gltf_get_index( gltf, json, "input", RF_GLTF_ACCESSORS ),
        output = rf_gltf_get_index( gltf, json, "output", RF_GLTF_ACCESSORS );
    RF_TRY( rf_json_result( json ) );
    RF_TRY( rf_gltf_open_accessor( gltf, input, where, 1, &times ) );
    RF_TRY( rf_gltf_open_accessor( gltf, output, where, 0, &values ) );

    loader->values += (uint64_t)times->count + (uint64_t)values->count * (uint64_t)values->components;
    if ( loader->values > MAX_VALUES )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "more than %llu numbers in the animations: bake fewer keys",
                             (unsigned long long)MAX_VALUES );
    channel->count = (int)times->count;
    RF_TRY( read_times( gltf, input, where, channel ) );
    RF_TRY( read_values( gltf, output, where, channel ) );
    return check_visibility( gltf, where, channel );
}

// What a channel animates.
typedef struct Target
{
    bool wanted;
    const char* unrendered; // a pointer to what cannot be rendered; NULL: there is none
    RfChange change;        // of a node: its channel's node and path alone, else the node is −1
} Target;

// KHR_animation_pointer: what a channel animates, as a path in the document. The templates are those of glTF's object model.

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
    RfChangedValue v = rf_next_value( owner, -1 );
    for ( ; v < RF_CHANGED_COUNT; v = rf_next_value( owner, v ) )
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

static void follow_to_value( RfValueOwner owner, const Pointer* parts, Target* out )
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

// Paths of nodes, as pointers have them.
static const char* const s_paths[] = { "translation", "rotation", "scale", "weights", "extensions/KHR_node_visibility/visible" };

// The place of one of the first `count`; −1: there is none.
static int find_node_path( const char* path, int count )
{
    while ( count > 0 && strcmp( path, s_paths[count - 1] ) != 0 )
        --count;
    return count - 1;
}

static void follow_to_node( const Pointer* parts, Target* out )
{
    int path = find_node_path( parts->member, RF_VISIBILITY + 1 );
    if ( path < 0 )
        return;
    out->change.channel.node = parts->index;
    out->change.channel.path = (RfAnimatedPath)path;
    out->wanted = true;
    out->unrendered = NULL;
}

static void follow( const Pointer* parts, Target* out )
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

// Follows the pointer of a target. What the reader ignores is not wanted.
static RfResult follow_pointer( RfGltf* gltf, const RfField* target, const char* where, Target* out )
{
    const char* pointer = "";
    Pointer parts;
    RfField extension = rf_gltf_extension( target, "KHR_animation_pointer" );
    if ( extension.json == NULL )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "target.extensions.KHR_animation_pointer is missing" );
    rf_gltf_require( &extension, "pointer", NULL );
    RF_TRY( rf_get_text( &extension, "pointer", &pointer ) );
    RF_TRY( take_apart( gltf, pointer, where, &parts ) );
    out->unrendered = pointer;
    if ( parts.list != NULL )
        follow( &parts, out );
    return RF_OK;
}

// Lists what a pointer names as not rendered.
static RfResult note_pointer( RfGltf* gltf, const char* pointer )
{
    Pointer parts;
    RF_TRY( take_apart( gltf, pointer, "animations", &parts ) );
    RfWhere what = name_target( gltf, pointer, &parts );
    return rf_gltf_note_unrendered( gltf, what.text, "the file animates '%.160s', which is not rendered", pointer );
}

static RfResult find_path( RfGltf* gltf, const RfField* target, const char* where, const char* path, Target* out )
{
    int known = find_node_path( path, RF_WEIGHTS + 1 );
    if ( strcmp( path, "pointer" ) == 0 )
        return follow_pointer( gltf, target, where, out );
    if ( known < 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "target.path '%.20s' does not exist", path );
    out->change.channel.path = (RfAnimatedPath)known;
    out->wanted = out->change.channel.node >= 0; // without a node, an extension defines the target
    return RF_OK;
}

// Reads what the channel animates.
static RfResult read_target( RfGltf* gltf, const RfField* json, Target* out )
{
    const char *path = "", *where = json->path;
    *out = ( Target ){ 0 };
    RfChannel* channel = &out->change.channel;
    rf_gltf_require( json, "target", NULL );
    RfField target = rf_get_object( json, "target" );
    snprintf( target.path, sizeof target.path, "%s", where ); // of which messages name the channel
    rf_gltf_require( &target, "path", NULL );
    rf_get_text( &target, "path", &path );
    channel->node = rf_gltf_get_index( gltf, &target, "node", RF_GLTF_NODES );
    if ( rf_json_result( json ) == RF_OK )
        find_path( gltf, &target, where, path, out );
    if ( rf_json_result( json ) != RF_OK || !out->wanted )
        return rf_json_result( json );
    if ( channel->path == RF_VALUE )
        channel->node = -1;
    else if ( channel->path == RF_WEIGHTS )
        return rf_gltf_count_targets( gltf, channel->node, where, &channel->components );
    else
        channel->components = channel->path == RF_ROTATION ? 4 : channel->path == RF_VISIBILITY ? 1 : 3;
    return RF_OK;
}

// What a channel animates, as a key.
static RfWhere name_change( const RfChange* change )
{
    const RfChannel* channel = &change->channel;
    return channel->path == RF_VALUE ? rf_where( "%d %d %d", (int)change->value, change->of, change->slot )
                                     : rf_where( "node %d %d", channel->node, (int)channel->path );
}

// The animation that has it: GIVEN comes from outside the file; −1: none.
static int find_owner( const Loader* loader, const RfChange* change )
{
    const json_t* owner = json_object_get( loader->owners, name_change( change ).text );
    return owner != NULL ? (int)json_integer_value( owner ) : -1;
}

static RfResult set_owner( const RfGltf* gltf, Loader* loader, const RfChange* change, int animation )
{
    return json_object_set_new( loader->owners, name_change( change ).text, json_integer( animation ) ) == 0
               ? RF_OK
               : rf_gltf_no_memory( gltf, "animations" );
}

// Takes what a channel animates for an animation, unless something has it.
static RfResult take_target( RfGltf* gltf, Loader* loader, const char* where, int animation, Target* target )
{
    const RfChange* change = &target->change;
    const RfChannel* channel = &change->channel;
    const RfNode* node = channel->path != RF_VALUE ? gltf->scene->nodes + channel->node : NULL;
    int owner = find_owner( loader, change );
    target->wanted = owner < 0;
    if ( node != NULL && node->has_matrix && channel->path <= RF_SCALE )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "moves nodes[%d], which has a matrix", channel->node );
    if ( owner < 0 )
        return set_owner( gltf, loader, change, animation );
    if ( owner != GIVEN && node != NULL )
        rf_gltf_notice( gltf, "%s moves node '%.80s', which an earlier channel moves: the first is used", where, node->name );
    else if ( owner != GIVEN )
        rf_gltf_notice( gltf, "%s changes %s, which an earlier channel changes: the first is used", where,
                        rf_changed_traits( change->value )->name );
    return RF_OK;
}

static RfResult append_channel( RfGltf* gltf, const RfChannel* channel )
{
    RfScene* scene = gltf->scene;
    if ( !rf_gltf_grow( &scene->channels, scene->channel_count, sizeof *scene->channels ) )
        return rf_gltf_no_memory( gltf, "animations" );
    scene->channels[scene->channel_count++] = *channel;
    return RF_OK;
}

static RfResult load_channel( RfGltf* gltf, Loader* loader, const RfField* json, const RfField* samplers, int animation )
{
    Target target;
    RfChannel* channel = &target.change.channel;
    RF_TRY( read_target( gltf, json, &target ) );
    if ( target.unrendered != NULL )
        RF_TRY( note_pointer( gltf, target.unrendered ) );
    if ( target.wanted )
        RF_TRY( take_target( gltf, loader, json->path, animation, &target ) );
    if ( !target.wanted )
        return RF_OK;

    int64_t number = -1;
    rf_gltf_require( json, "sampler", NULL );
    RF_TRY( rf_get_integer( json, "sampler", 0, (int64_t)json_array_size( samplers->json ) - 1, &number ) );
    RfField sampler = rf_field_item( samplers, (size_t)number );
    if ( json_is_object( sampler.json ) == 0 )
        return rf_field_fail( &sampler, "must be an object" );
    RfResult result = read_sampler( gltf, loader, &sampler, channel );
    if ( result == RF_OK && channel->path == RF_VALUE )
        result = rf_gltf_check_change( gltf, sampler.path, &target.change );
    if ( result == RF_OK )
        result = channel->path == RF_VALUE ? rf_gltf_add_change( gltf, &target.change ) : append_channel( gltf, channel );
    if ( result != RF_OK )
        rf_destroy_channel( channel );
    return result; // NOLINT(clang-analyzer-unix.Malloc): what appends does not fail with RF_OK
}

// Whether an animation moves what one before it moves.
static RfResult find_conflict( RfGltf* gltf, const Loader* loader, const RfField* channels, int* other )
{
    *other = -1;
    for ( size_t i = 0; *other < 0 && i < json_array_size( channels->json ); ++i )
    {
        Target target;
        RfField channel = rf_field_item( channels, i );
        if ( !json_is_object( channel.json ) )
            return rf_field_fail( &channel, "must be an object" );
        RF_TRY( read_target( gltf, &channel, &target ) );
        int owner = target.wanted ? find_owner( loader, &target.change ) : -1;
        *other = owner != GIVEN ? owner : -1;
    }
    return rf_json_result( channels );
}

static RfResult load_animation( RfGltf* gltf, Loader* loader, int index )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_ANIMATIONS, index );
    RfField channels = rf_get_array( &json, "channels" ), samplers = rf_get_array( &json, "samplers" );
    int other = -1;
    RfResult result = find_conflict( gltf, loader, &channels, &other );
    if ( result == RF_OK && other >= 0 )
    {
        loader->instead = loader->left_out_count == 0 ? other : loader->instead;
        loader->left_out[loader->left_out_count++] = index;
        return RF_OK;
    }
    for ( size_t i = 0; result == RF_OK && i < json_array_size( channels.json ); ++i )
    {
        RfField channel = rf_field_item( &channels, i );
        result = load_channel( gltf, loader, &channel, &samplers, index );
    }
    return result;
}

static RfWhere name_animation( const RfGltf* gltf, int index )
{
    const char* name = json_string_value( json_object_get( rf_gltf_item( gltf, RF_GLTF_ANIMATIONS, index ), "name" ) );
    return name != NULL && name[0] != 0 ? rf_where( "'%.50s'", name ) : rf_where( "animations[%d]", index );
}

static bool is_called( const RfGltf* gltf, int index, const char* name )
{
    const char* own = json_string_value( json_object_get( rf_gltf_item( gltf, RF_GLTF_ANIMATIONS, index ), "name" ) );
    return own != NULL && strcmp( own, name ) == 0;
}

// The names of some animations, each once: all where `list` is NULL.
static void name_animations( const RfGltf* gltf, const int* list, int count, char text[MAX_NAMED * 64 + 32] )
{
    RfWhere named[MAX_NAMED];
    int known = 0, more = 0;
    char* end = text;
    *end = 0;
    for ( int i = 0; i < count; ++i )
    {
        RfWhere name = name_animation( gltf, list != NULL ? list[i] : i );
        bool again = false;
        for ( int k = 0; k < known; ++k )
            again = again || strcmp( named[k].text, name.text ) == 0;
        if ( again )
            continue;
        more += known == MAX_NAMED;
        if ( known == MAX_NAMED )
            continue;
        end += snprintf( end, 64, "%s%.55s", known > 0 ? ", " : "", name.text );
        named[known++] = name;
    }
    if ( more > 0 )
        snprintf( end, 32, " and %d more", more );
}

static void warn_of_left_out( const RfGltf* gltf, const Loader* loader )
{
    char names[MAX_NAMED * 64 + 32];
    if ( loader->left_out_count == 0 )
        return;
    name_animations( gltf, loader->left_out, loader->left_out_count, names );
    RfWhere used = name_animation( gltf, loader->instead );
    rf_warn( gltf->log, "%s: animation %s is used: %s, which move%s the same, %s left out", gltf->path, used.text, names,
             loader->left_out_count == 1 ? "s" : "", loader->left_out_count == 1 ? "is" : "are" );
}

// That there is an animation of the name that is chosen.
static RfResult check_chosen( const RfGltf* gltf )
{
    char names[MAX_NAMED * 64 + 32];
    int count = gltf->counts[RF_GLTF_ANIMATIONS];
    for ( int i = 0; i < count; ++i )
    {
        if ( is_called( gltf, i, gltf->options->animation ) )
            return RF_OK;
    }
    name_animations( gltf, NULL, count, names );
    return rf_gltf_fail( gltf, RF_ERROR_USAGE, "animations", "none is called '%.80s'%s%s", gltf->options->animation,
                         count > 0 ? ": there are " : ": there are none", names );
}

// What comes from outside the file, of which the times are those of the scene.
static RfResult add_given( RfGltf* gltf, Loader* loader )
{
    const RfGltfOptions* options = gltf->options;
    RfResult result = RF_OK;
    for ( int i = 0; result == RF_OK && i < options->channel_count; ++i )
    {
        RfChannel channel = { 0 };
        RfChange change = { .channel = options->channels[i] };
        change.channel.node = rf_gltf_given_node( gltf, options->channels + i );
        result = set_owner( gltf, loader, &change, GIVEN );
        if ( result != RF_OK || change.channel.count == 0 )
            continue;
        result = rf_copy_channel( &change.channel, &channel, gltf->error );
        if ( result == RF_OK )
            result = append_channel( gltf, &channel );
        if ( result != RF_OK )
            rf_destroy_channel( &channel );
    }
    return result; // NOLINT(clang-analyzer-unix.Malloc): append_channel does not fail with RF_OK
}

// The same of a material.
static RfResult add_given_values( RfGltf* gltf, Loader* loader, int material )
{
    int before = gltf->change_count;
    RfResult result = rf_gltf_read_keys( gltf, material );
    for ( int i = before; result == RF_OK && i < gltf->change_count; ++i )
        result = set_owner( gltf, loader, gltf->changes + i, GIVEN );
    for ( RfChangedValue v = rf_next_value( RF_OF_MATERIAL, -1 ); result == RF_OK && v < RF_CHANGED_COUNT;
          v = rf_next_value( RF_OF_MATERIAL, v ) )
    {
        const RfChange change = { .value = v, .of = material, .channel.path = RF_VALUE };
        if ( rf_has_member( gltf->material_edits + material, rf_changed_traits( v )->name ) )
            result = set_owner( gltf, loader, &change, GIVEN );
    }
    return result;
}

static void find_keys( const RfChannel* channel, RfClock* all )
{
    all->first = fmin( all->first, channel->times[0] );
    all->last = fmax( all->last, channel->times[channel->count - 1] );
}

// Sets the clock of the file's own channels, from the first of their keys to the last.
static void set_clock( RfGltf* gltf, RfChannel* channels, int count, int given_changes )
{
    RfClock all = *gltf->options->clock;
    all.first = (double)INFINITY;
    all.last = -(double)INFINITY;
    for ( int i = 0; i < count; ++i )
        find_keys( channels + i, &all );
    for ( int i = given_changes; i < gltf->change_count; ++i )
        find_keys( &gltf->changes[i].channel, &all );
    for ( int i = 0; i < count; ++i )
        channels[i].clock = all;
    for ( int i = given_changes; i < gltf->change_count; ++i )
        gltf->changes[i].channel.clock = all;
}

// Those of the name that is chosen go before the others: a file may have one for each of its objects.
static RfResult load_all( RfGltf* gltf, Loader* loader )
{
    int count = gltf->counts[RF_GLTF_ANIMATIONS];
    RfResult result = add_given( gltf, loader );
    int given = gltf->scene->channel_count;
    for ( int i = 0; result == RF_OK && gltf->material_edits != NULL && i < gltf->counts[RF_GLTF_MATERIALS]; ++i )
        result = add_given_values( gltf, loader, i );
    int given_changes = gltf->change_count;
    if ( result == RF_OK && gltf->options->animation != NULL )
        result = check_chosen( gltf );
    for ( int i = 0; result == RF_OK && gltf->options->animation != NULL && i < count; ++i )
    {
        if ( is_called( gltf, i, gltf->options->animation ) )
            result = load_animation( gltf, loader, i );
    }
    if ( result == RF_OK ) // of the same name
        warn_of_left_out( gltf, loader );
    for ( int i = 0; result == RF_OK && i < count; ++i )
    {
        if ( gltf->options->animation == NULL || !is_called( gltf, i, gltf->options->animation ) )
            result = load_animation( gltf, loader, i );
    }
    if ( result == RF_OK && gltf->options->animation == NULL )
        warn_of_left_out( gltf, loader );
    if ( result == RF_OK && gltf->options->clock != NULL )
        set_clock( gltf, gltf->scene->channels + given, gltf->scene->channel_count - given, given_changes );
    return result;
}

static int compare_channels( const void* a, const void* b )
{
    const RfChannel *left = a, *right = b;
    if ( left->node != right->node )
        return left->node < right->node ? -1 : 1;
    return (int)left->path - (int)right->path;
}

static void widen( RfGltfSpan* span, double start, double end )
{
    span->start = fmin( span->start, start );
    span->end = fmax( span->end, end );
}

static void find_spans( RfGltf* gltf )
{
    const RfScene* scene = gltf->scene;
    for ( int i = 0; i < scene->channel_count; ++i )
    {
        const RfChannel* channel = scene->channels + i;
        if ( channel->path > RF_SCALE ) // which moves nothing
            continue;
        double start, end;
        rf_channel_span( channel, &start, &end );
        widen( &gltf->nodes[channel->node].span, start, end );
    }
    // parents come first, so one pass propagates all ancestors
    for ( int i = 0; i < gltf->order_count; ++i )
    {
        int node = gltf->order[i], parent = scene->nodes[node].parent;
        if ( parent >= 0 )
            widen( &gltf->nodes[node].span, gltf->nodes[parent].span.start, gltf->nodes[parent].span.end );
    }
}

RfResult rf_gltf_load_animations( RfGltf* gltf )
{
    Loader loader = { .owners = json_object(),
                      .left_out = calloc( (size_t)gltf->counts[RF_GLTF_ANIMATIONS] + 1, sizeof *loader.left_out ) };
    bool room = loader.owners != NULL && loader.left_out != NULL;
    RfResult result = room ? load_all( gltf, &loader ) : rf_gltf_no_memory( gltf, "animations" );
    free( loader.left_out );
    json_decref( loader.owners );
    if ( result != RF_OK )
        return result;
    if ( gltf->scene->channel_count > 0 )
        qsort( gltf->scene->channels, (size_t)gltf->scene->channel_count, sizeof( RfChannel ), compare_channels );
    find_spans( gltf );
    return rf_gltf_sort_changes( gltf );
}
