// Light groups: tags of lights, nodes and materials. Meshes of nodes that are tagged emit by materials of that tag: by the material
// itself for the first group that it is in, by copies for the others.
#include "gltf/gltf_document.h"

#include "scene/light_groups.h"

#include <stdlib.h>
#include <string.h>

#define UNTAGGED ( -1 )
#define MOST_COPIED ( 1 << 20 ) // so that a small file cannot ask for any amount of memory

RfResult rf_gltf_read_tag( const RfGltf* gltf, const RfField* ours, int* tag )
{
    uint16_t number = 0;
    const char* name;
    *tag = UNTAGGED;
    if ( !rf_has_member( ours, "light_group" ) )
        return gltf->error->code;
    RfResult result = rf_read_light_group( ours, &name );
    if ( result == RF_OK && !rf_tag_light( gltf->scene, name, &number ) )
        return rf_field_no_memory( ours );
    *tag = result == RF_OK ? (int)number : UNTAGGED;
    return result;
}

RfResult rf_gltf_read_light_group( const RfGltf* gltf, const RfField* object, int* tag )
{
    RfField ours = rf_gltf_extras( object );
    return rf_gltf_read_tag( gltf, &ours, tag );
}

// What nodes with one tag use of a list: a mesh, or a material.
typedef struct Use
{
    int item, tag, next; // next: of the same item, or −1
    int target;          // what they use in its place
} Use;

typedef struct Uses
{
    int* first; // per item, or −1
    Use* list;
    int count;
} Uses;

typedef struct RfGltfSplit
{
    Uses meshes, materials;
} RfGltfSplit;

static bool open_uses( int items, Uses* uses )
{
    uses->first = malloc( ( (size_t)items + 1 ) * sizeof *uses->first );
    for ( int i = 0; uses->first != NULL && i < items; ++i )
        uses->first[i] = -1;
    return uses->first != NULL;
}

void rf_gltf_free_split( RfGltf* gltf )
{
    RfGltfSplit* split = gltf->split;
    if ( split == NULL )
        return;
    free( split->meshes.first );
    free( split->meshes.list );
    free( split->materials.first );
    free( split->materials.list );
    free( split );
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
    if ( !rf_gltf_grow( &uses->list, uses->count, sizeof *uses->list ) )
        return false;
    int* link = uses->first + item;
    while ( *link >= 0 && tag != UNTAGGED )
        link = &uses->list[*link].next;
    uses->list[uses->count] = ( Use ){ item, tag, *link, item };
    *link = uses->count++;
    return true;
}

// The material of a primitive if it ever emits, else −1.
static int emitter_of( const RfGltf* gltf, const RfField* primitive )
{
    int material = -1;
    bool emits = rf_gltf_material_of( gltf, primitive, &material ) == RF_OK && material >= 0 &&
                 rf_emits( gltf->scene->materials + material );
    return emits ? material : -1;
}

// Calls `visit` with all emitters of the meshes that are used. False: it did not want to go on.
static bool visit_emitters( RfGltf* gltf, bool ( *visit )( RfGltfSplit* split, Use* mesh, int material ) )
{
    RfGltfSplit* split = gltf->split;
    bool going = true;
    for ( int u = 0; going && u < split->meshes.count; ++u )
    {
        RfField primitives = rf_gltf_primitives( gltf, split->meshes.list[u].item );
        for ( size_t i = 0; going && i < json_array_size( primitives.json ); ++i )
        {
            RfField primitive = rf_field_item( &primitives, i );
            int material = emitter_of( gltf, &primitive );
            going = material < 0 || visit( split, split->meshes.list + u, material );
        }
    }
    return going;
}

static bool add_emitter( RfGltfSplit* split, Use* mesh, int material )
{
    return add_use( &split->materials, material, mesh->tag );
}

// A mesh of another material than its own is dressed.
static bool mark_dressed( RfGltfSplit* split, Use* mesh, int material )
{
    if ( find_use( &split->materials, material, mesh->tag )->target != material )
        mesh->target = -1;
    return true;
}

static bool copy_material( RfGltf* gltf, int from, int to )
{
    RfMaterial *original = gltf->scene->materials + from, *copy = gltf->scene->materials + to;
    int moving = gltf->moving_material_count;
    *copy = *original;
    copy->name = strdup( original->name );
    copy->textured = original->textured != NULL ? malloc( sizeof *copy->textured ) : NULL;
    gltf->scene->material_count += 1;
    if ( copy->name == NULL || ( copy->textured == NULL && original->textured != NULL ) )
        return false;
    if ( copy->textured != NULL )
        *copy->textured = *original->textured;
    for ( int i = 0; i < moving; ++i )
    {
        RfMovingMaterial changing = gltf->moving_materials[i];
        if ( changing.material != from )
            continue;
        changing.material = to;
        return rf_gltf_add_moving_material( gltf, &changing ) == RF_OK;
    }
    return true;
}

// The first use of a material keeps it, the others get copies.
static RfResult split_materials( RfGltf* gltf )
{
    RfScene* scene = gltf->scene;
    Uses* uses = &gltf->split->materials;
    int copies = 0;
    for ( int u = 0; u < uses->count; ++u )
        copies += uses->list[u].next >= 0;
    if ( copies > MOST_COPIED )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, "meshes",
                             "more than %d materials in several light groups: split the scene", MOST_COPIED );
    if ( !rf_make_room( &scene->materials, scene->material_count + (size_t)copies, sizeof *scene->materials ) )
        return rf_gltf_no_memory( gltf, "materials" );
    memset( scene->materials + scene->material_count, 0, ( (size_t)copies + 1 ) * sizeof *scene->materials );
    for ( int m = 0; m < gltf->counts[RF_GLTF_MATERIALS]; ++m )
    {
        for ( int at = uses->first[m]; at >= 0; at = uses->list[at].next )
        {
            Use* use = uses->list + at;
            use->target = at == uses->first[m] ? m : (int)scene->material_count;
            if ( use->target != m && !copy_material( gltf, m, use->target ) )
                return rf_gltf_no_memory( gltf, "materials" );
            if ( use->tag != UNTAGGED )
                scene->materials[use->target].light_group = (uint16_t)use->tag;
        }
    }
    return RF_OK;
}

static RfResult add_mesh_use( RfGltf* gltf, int mesh, int tag )
{
    if ( !rf_gltf_grow( &gltf->uses, gltf->use_count, sizeof *gltf->uses ) )
        return rf_gltf_no_memory( gltf, "meshes" );
    gltf->uses[gltf->use_count++] = ( RfGltfUse ){ .mesh = mesh, .light_group = tag, .first = -1, .shapes = { -1, -1, -1, -1 } };
    return RF_OK;
}

// A mesh that all of its nodes have in one way stays one; others become further ones, after those of the document.
static RfResult split_meshes( RfGltf* gltf )
{
    const Uses* uses = &gltf->split->meshes;
    RfResult result = gltf->error->code;
    visit_emitters( gltf, mark_dressed );
    for ( int u = 0; result == RF_OK && u < uses->count; ++u )
    {
        Use* use = uses->list + u;
        bool alone = uses->list[uses->first[use->item]].next < 0, dressed = use->target < 0;
        use->target = dressed && !alone ? gltf->use_count : use->item;
        if ( use->target != use->item )
            result = add_mesh_use( gltf, use->item, use->tag );
        else if ( alone )
            gltf->uses[use->item].light_group = use->tag;
    }
    for ( int i = 0; result == RF_OK && i < gltf->counts[RF_GLTF_NODES]; ++i )
    {
        RfGltfNode* node = gltf->nodes + i;
        node->use = node->mesh >= 0 ? find_use( uses, node->mesh, node->light_group )->target : -1;
    }
    return result;
}

RfResult rf_gltf_split_light_groups( RfGltf* gltf )
{
    bool any = false;
    RfResult result = RF_OK;
    for ( int m = 0; result == RF_OK && m < gltf->counts[RF_GLTF_MESHES]; ++m )
        result = add_mesh_use( gltf, m, UNTAGGED );
    for ( int i = 0; i < gltf->counts[RF_GLTF_NODES]; ++i )
        any = any || ( gltf->nodes[i].mesh >= 0 && gltf->nodes[i].light_group != UNTAGGED );
    RfGltfSplit* split = any ? calloc( 1, sizeof *split ) : NULL;
    gltf->split = split;
    if ( !any || result != RF_OK )
        return result;
    bool room = split != NULL && open_uses( gltf->counts[RF_GLTF_MESHES], &split->meshes ) &&
                open_uses( gltf->counts[RF_GLTF_MATERIALS], &split->materials );
    for ( int i = 0; room && i < gltf->counts[RF_GLTF_NODES]; ++i )
        room = gltf->nodes[i].mesh < 0 || add_use( &split->meshes, gltf->nodes[i].mesh, gltf->nodes[i].light_group );
    if ( !room || !visit_emitters( gltf, add_emitter ) )
        return rf_gltf_no_memory( gltf, "materials" );
    result = gltf->error->code == RF_OK ? split_materials( gltf ) : gltf->error->code;
    return result == RF_OK ? split_meshes( gltf ) : result;
}

uint32_t rf_gltf_tagged_material( const RfGltf* gltf, int use, uint32_t material )
{
    const RfGltfSplit* split = gltf->split;
    if ( split == NULL || material >= (uint32_t)gltf->counts[RF_GLTF_MATERIALS] )
        return material;
    const Use* found = find_use( &split->materials, (int)material, gltf->uses[use].light_group );
    return found != NULL ? (uint32_t)found->target : material;
}
