// Light groups: tags of lights, nodes and materials. The meshes of nodes that are tagged get materials of their own in the document,
// before anything reads them.
#include "scene/gltf/gltf_changes.h"

#include "base/json.h"
#include "scene/animation.h"
#include "scene/light_groups.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define UNTAGGED ( -1 )
#define MOST_COPIED ( 1 << 20 ) // primitives, so that a small file cannot ask for any amount of memory

RfResult rf_gltf_read_light_group( const RfGltf* gltf, const RfField* object, int* tag )
{
    uint16_t number = 0;
    const char* name;
    RfField ours = rf_gltf_extras( object );
    *tag = UNTAGGED;
    if ( !rf_has_member( &ours, "light_group" ) )
        return rf_json_result( object );
    RfResult result = rf_read_light_group( &ours, &name );
    if ( result == RF_OK && !rf_tag_light( gltf->scene, name, &number ) )
        return rf_field_no_memory( &ours );
    *tag = result == RF_OK ? (int)number : UNTAGGED;
    return result;
}

// What nodes with one tag use of a list: a mesh, or a material.
typedef struct Use
{
    int item, tag, next; // next: of the same item, or −1
    int target;          // the item that has the tag
} Use;

typedef struct Uses
{
    int* first; // per item, or −1
    Use* list;
    int count, capacity;
} Uses;

typedef struct Split
{
    RfGltf* gltf;
    int* node_tag; // per node
    int* mesh_of;  // likewise; −1: none
    bool* emits;   // per material
    Uses meshes, materials;
    int copied;
} Split;

static bool open_uses( int items, Uses* uses )
{
    uses->first = malloc( ( (size_t)items + 1 ) * sizeof *uses->first );
    for ( int i = 0; uses->first != NULL && i < items; ++i )
        uses->first[i] = -1;
    return uses->first != NULL;
}

static void close_uses( Uses* uses )
{
    free( uses->first );
    free( uses->list );
}

static Use* find_use( const Uses* uses, int item, int tag )
{
    int at = uses->first[item];
    while ( at >= 0 && uses->list[at].tag != tag )
        at = uses->list[at].next;
    return at >= 0 ? uses->list + at : NULL;
}

// Untagged uses come first of their item, so that it stays what it is for them.
static bool add_use( Uses* uses, int item, int tag )
{
    if ( find_use( uses, item, tag ) != NULL )
        return true;
    if ( uses->count == uses->capacity )
    {
        uses->capacity = uses->capacity > 0 ? 2 * uses->capacity : 16;
        Use* grown = realloc( uses->list, (size_t)uses->capacity * sizeof *grown );
        if ( grown == NULL )
            return false;
        uses->list = grown;
    }
    int* link = uses->first + item;
    while ( *link >= 0 && tag != UNTAGGED )
        link = &uses->list[*link].next;
    uses->list[uses->count] = ( Use ){ item, tag, *link, item };
    *link = uses->count++;
    return true;
}

static bool is_lit( const json_t* material )
{
    const json_t* factor = json_object_get( material, "emissiveFactor" );
    for ( size_t i = 0; i < 3; ++i )
    {
        if ( json_number_value( json_array_get( factor, i ) ) > 0.0 )
            return true;
    }
    return json_object_get( json_object_get( material, "extensions" ), "KHR_materials_unlit" ) != NULL;
}

// What changes may come to emit, and what is made to.
static void mark_changing( const Split* s )
{
    const RfGltf* gltf = s->gltf;
    for ( int i = 0; i < gltf->counts[RF_GLTF_ANIMATIONS]; ++i )
    {
        const json_t *channels = json_object_get( rf_gltf_item( gltf, RF_GLTF_ANIMATIONS, i ), "channels" ), *channel;
        size_t k;
        json_array_foreach( channels, k, channel )
        {
            const json_t* extensions = json_object_get( json_object_get( channel, "target" ), "extensions" );
            const char* pointer =
                json_string_value( json_object_get( json_object_get( extensions, "KHR_animation_pointer" ), "pointer" ) );
            int material;
            if ( pointer != NULL && sscanf( pointer, "/materials/%9d/", &material ) == 1 && material >= 0 &&
                 material < gltf->counts[RF_GLTF_MATERIALS] )
                s->emits[material] = true;
        }
    }
    for ( int i = 0; i < gltf->options->change_count; ++i )
        s->emits[gltf->options->changes[i].of] = true;
    for ( int i = 0; i < gltf->options->override_count; ++i )
    {
        const RfOverride* override = gltf->options->overrides + i;
        const double* rgb = override->numbers;
        if ( override->value == RF_CHANGED_EMISSIVE && rgb[0] + rgb[1] + rgb[2] > 0.0 )
            s->emits[override->material] = true;
    }
}

// The material of a primitive that emits, or −1.
static int emitter_of( const Split* s, const json_t* primitive )
{
    const json_t* material = json_object_get( primitive, "material" );
    json_int_t index = json_is_integer( material ) ? json_integer_value( material ) : -1;
    return index >= 0 && index < s->gltf->counts[RF_GLTF_MATERIALS] && s->emits[index] ? (int)index : -1;
}

static const json_t* primitives_of( const Split* s, int mesh )
{
    return json_object_get( rf_gltf_item( s->gltf, RF_GLTF_MESHES, mesh ), "primitives" );
}

static bool list_materials( Split* s )
{
    bool room = true;
    for ( int m = 0; m < s->meshes.count; ++m )
    {
        const json_t* primitive;
        size_t i;
        json_array_foreach( primitives_of( s, s->meshes.list[m].item ), i, primitive )
        {
            int material = emitter_of( s, primitive );
            room = room && ( material < 0 || add_use( &s->materials, material, s->meshes.list[m].tag ) );
        }
    }
    return room;
}

static bool tag_material( const Split* s, json_t* material, int tag )
{
    const char* name = tag > 0 ? s->gltf->scene->light_groups[tag - 1] : RF_LIGHT_GROUP_REST;
    json_t* extras = json_copy( json_object_get( material, "extras" ) );
    if ( !json_is_object( extras ) )
    {
        json_decref( extras );
        extras = json_object();
    }
    json_t* ours = json_copy( json_object_get( extras, "reframe" ) );
    if ( ours == NULL )
        ours = json_object();
    // of another type it is an error where materials are read
    if ( json_is_object( ours ) && json_object_set_new( ours, "light_group", json_string( name ) ) != 0 )
    {
        json_decref( ours );
        ours = NULL;
    }
    bool done = ours != NULL && json_object_set_new( extras, "reframe", ours ) == 0;
    return json_object_set_new( material, "extras", extras ) == 0 && done;
}

static bool add_copy( RfGltf* gltf, int from, int to )
{
    RfGltfCopy* grown = realloc( gltf->copies, ( (size_t)gltf->copy_count + 1 ) * sizeof *grown );
    if ( grown == NULL )
        return false;
    gltf->copies = grown;
    gltf->copies[gltf->copy_count++] = ( RfGltfCopy ){ from, to };
    return true;
}

// The first use of a material keeps it, the others get copies.
static bool split_material( Split* s, int material )
{
    RfGltf* gltf = s->gltf;
    json_t* list = (json_t*)gltf->lists[RF_GLTF_MATERIALS];
    json_t* original = json_array_get( list, (size_t)material );
    bool room = true;
    int first = s->materials.first[material];
    for ( int at = s->materials.list[first].next; room && at >= 0; at = s->materials.list[at].next )
    {
        json_t* copy = json_copy( original );
        room = copy != NULL && tag_material( s, copy, s->materials.list[at].tag );
        room = json_array_append_new( list, copy ) == 0 && room;
        s->materials.list[at].target = gltf->counts[RF_GLTF_MATERIALS]++;
        room = room && add_copy( gltf, material, s->materials.list[at].target );
    }
    return room && ( s->materials.list[first].tag == UNTAGGED || tag_material( s, original, s->materials.list[first].tag ) );
}

// A mesh as its use has it; NULL: as it is.
static bool dress_mesh( Split* s, const Use* use, json_t** dressed )
{
    json_t *list = NULL, *primitive;
    bool room = true;
    size_t i;
    *dressed = NULL;
    json_array_foreach( primitives_of( s, use->item ), i, primitive )
    {
        int material = emitter_of( s, primitive ), target = material;
        if ( material >= 0 )
            target = find_use( &s->materials, material, use->tag )->target;
        if ( target == material )
            continue;
        if ( list == NULL )
            list = json_copy( (json_t*)primitives_of( s, use->item ) );
        json_t* copy = json_copy( primitive );
        room = room && json_object_set_new( copy, "material", json_integer( target ) ) == 0;
        room = json_array_set_new( list, i, copy ) == 0 && room;
    }
    if ( list == NULL )
        return room;
    s->copied += (int)json_array_size( list );
    *dressed = json_copy( (json_t*)rf_gltf_item( s->gltf, RF_GLTF_MESHES, use->item ) );
    return json_object_set_new( *dressed, "primitives", list ) == 0 && room;
}

static RfResult split_meshes( Split* s )
{
    RfGltf* gltf = s->gltf;
    json_t* list = (json_t*)gltf->lists[RF_GLTF_MESHES];
    bool room = true;
    for ( int u = 0; room && u < s->meshes.count; ++u )
    {
        Use* use = s->meshes.list + u;
        json_t* dressed;
        room = dress_mesh( s, use, &dressed );
        if ( dressed == NULL )
            continue;
        bool alone = s->meshes.list[s->meshes.first[use->item]].next < 0;
        if ( s->copied > MOST_COPIED )
        {
            json_decref( dressed );
            return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "meshes",
                                 "more than %d primitives in several light groups: split the scene", MOST_COPIED );
        }
        use->target = alone ? use->item : gltf->counts[RF_GLTF_MESHES]++;
        room = ( alone ? json_array_set_new( list, (size_t)use->item, dressed ) : json_array_append_new( list, dressed ) ) == 0 &&
               room;
    }
    for ( int i = 0; room && i < gltf->counts[RF_GLTF_NODES]; ++i )
    {
        const Use* use = s->mesh_of[i] >= 0 ? find_use( &s->meshes, s->mesh_of[i], s->node_tag[i] ) : NULL;
        if ( use != NULL && use->target != use->item )
            room =
                json_object_set_new( (json_t*)rf_gltf_item( gltf, RF_GLTF_NODES, i ), "mesh", json_integer( use->target ) ) == 0;
    }
    return room ? RF_OK : rf_gltf_no_memory( gltf, "meshes" );
}

// Reads the tags of all nodes. `any`: some node with a mesh has one.
static RfResult read_nodes( Split* s, bool* any )
{
    RfGltf* gltf = s->gltf;
    RfResult result = RF_OK;
    *any = false;
    for ( int i = 0; result == RF_OK && i < gltf->counts[RF_GLTF_NODES]; ++i )
    {
        RfField node = rf_gltf_item_field( gltf, RF_GLTF_NODES, i );
        const json_t* mesh = json_object_get( node.json, "mesh" );
        json_int_t index = json_is_integer( mesh ) ? json_integer_value( mesh ) : -1;
        s->mesh_of[i] =
            index >= 0 && index < gltf->counts[RF_GLTF_MESHES] ? (int)index : -1; // else an error where nodes are read
        result = rf_gltf_read_light_group( gltf, &node, s->node_tag + i );
        *any = *any || ( s->mesh_of[i] >= 0 && s->node_tag[i] != UNTAGGED );
    }
    return result;
}

static RfResult split( Split* s )
{
    RfGltf* gltf = s->gltf;
    int materials = gltf->counts[RF_GLTF_MATERIALS];
    bool room = true;
    for ( int i = 0; i < materials; ++i )
        s->emits[i] = is_lit( rf_gltf_item( gltf, RF_GLTF_MATERIALS, i ) );
    mark_changing( s );
    for ( int i = 0; i < gltf->counts[RF_GLTF_NODES]; ++i )
        room = room && ( s->mesh_of[i] < 0 || add_use( &s->meshes, s->mesh_of[i], s->node_tag[i] ) );
    room = room && list_materials( s );
    for ( int i = 0; room && i < materials; ++i )
        room = s->materials.first[i] < 0 || split_material( s, i );
    return room ? split_meshes( s ) : rf_gltf_no_memory( gltf, "materials" );
}

RfResult rf_gltf_split_light_groups( RfGltf* gltf )
{
    Split s = { .gltf = gltf };
    bool any = false;
    size_t nodes = (size_t)gltf->counts[RF_GLTF_NODES] + 1;
    s.node_tag = malloc( nodes * sizeof *s.node_tag );
    s.mesh_of = malloc( nodes * sizeof *s.mesh_of );
    s.emits = calloc( (size_t)gltf->counts[RF_GLTF_MATERIALS] + 1, sizeof *s.emits );
    bool room = s.node_tag != NULL && s.mesh_of != NULL && s.emits != NULL &&
                open_uses( gltf->counts[RF_GLTF_MESHES], &s.meshes ) &&
                open_uses( gltf->counts[RF_GLTF_MATERIALS], &s.materials );
    RfResult result = room ? read_nodes( &s, &any ) : rf_gltf_no_memory( gltf, "nodes" );
    if ( result == RF_OK && any )
        result = split( &s );
    free( s.node_tag );
    free( s.mesh_of );
    free( s.emits );
    close_uses( &s.meshes );
    close_uses( &s.materials );
    return result;
}

RfResult rf_gltf_copy_changes( RfGltf* gltf )
{
    RfResult result = RF_OK;
    int count = gltf->copy_count > 0 ? gltf->change_count : 0;
    for ( int i = 0; i < count; ++i )
    {
        for ( int k = 0; result == RF_OK && k < gltf->copy_count; ++k )
        {
            RfChange change = gltf->changes[i];
            if ( change.of != gltf->copies[k].from || !rf_is_of_material( change.value ) )
                continue;
            change.of = gltf->copies[k].to;
            result = rf_copy_channel( &gltf->changes[i].channel, &change.channel, gltf->error );
            if ( result == RF_OK )
                result = rf_gltf_add_change( gltf, &change );
            if ( result != RF_OK )
                rf_destroy_channel( &change.channel );
        }
    }
    return result;
}
