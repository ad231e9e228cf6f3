// KHR_draco_mesh_compression: accessors of meshes that libdraco decodes; without the library, the uncompressed ones.
#include "base/try.h"
#include "gltf/gltf_document.h"
#include "gltf/draco_mesh.h"

#include <stdlib.h>

#define EXTENSION "KHR_draco_mesh_compression"

#ifdef REFRAME_DRACO

static void free_mesh( RfGltfUnpackedView* view )
{
    int attributes = view->mesh != NULL && view->attributes != NULL ? rf_draco_attributes( view->mesh ) : 0;
    for ( int i = 0; i < attributes; ++i )
        free( view->attributes[i].values );
    free( view->attributes );
    free( view->corners );
    rf_draco_free( view->mesh );
}

// Triangles of a few bytes: a regular mesh may take 0.01 bits for each.
#define LEAST_FACES ( (uint64_t)1 << 22 )
#define FACES_PER_BYTE 256
#define MOST_FACES ( UINT32_MAX / 3 )

static RfResult fail_decode( const RfGltf* gltf, const char* where, RfDracoResult result, uint64_t most_faces )
{
    switch ( result )
    {
        case RF_DRACO_MEMORY: return rf_gltf_no_memory( gltf, where );
        case RF_DRACO_NO_MESH: return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "holds points of Draco, not a mesh" );
        case RF_DRACO_TOO_LARGE:
            return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where,
                                 "unpacks to more than %llu triangles or %llu bytes, the limits for a file of this size: "
                                 "split the scene",
                                 (unsigned long long)most_faces, (unsigned long long)gltf->unpacked->room );
        default: return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "is not a mesh that Draco decodes" );
    }
}

static RfResult copy_indices( const RfGltf* gltf, const char* where, RfGltfUnpackedView* out )
{
    uint64_t faces = rf_draco_faces( out->mesh ), bytes = 12 * faces; // fewer than 2³² indices, by MOST_FACES
    if ( faces == 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "holds a mesh of Draco without triangles" );
    RfResult result = rf_gltf_take_room( gltf, where, rf_draco_bytes( out->mesh ) + bytes );
    out->corners = result == RF_OK ? malloc( bytes ) : NULL;
    out->attributes = calloc( (size_t)rf_draco_attributes( out->mesh ) + 1, sizeof *out->attributes );
    if ( result == RF_OK && ( out->corners == NULL || out->attributes == NULL ) )
        return rf_gltf_no_memory( gltf, where );
    if ( result != RF_OK )
        return result;
    rf_draco_copy_indices( out->mesh, out->corners );
    out->indices = ( RfGltfAccessor ){ .open = true,
                                       .count = (uint32_t)( 3 * faces ),
                                       .components = 1,
                                       .component_type = 5125,
                                       .data = (const uint8_t*)out->corners,
                                       .stride = 4 };
    return RF_OK;
}

static RfResult open_mesh( const RfGltf* gltf, int view, RfGltfUnpackedView** out )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_BUFFER_VIEWS, view );
    *out = gltf->unpacked->views + view;
    if ( ( *out )->attributes != NULL )
        return RF_OK;
    size_t length = 0;
    const uint8_t* bytes;
    RF_TRY( rf_gltf_whole_view( gltf, json.path, view, INT64_MAX, &bytes, &length ) );
    uint64_t most_faces = LEAST_FACES + FACES_PER_BYTE * (uint64_t)length;
    most_faces = most_faces < MOST_FACES ? most_faces : MOST_FACES;
    RfDracoResult decoded = rf_draco_decode( bytes, length, most_faces, gltf->unpacked->room, &( *out )->mesh );
    if ( decoded != RF_DRACO_OK )
        return fail_decode( gltf, json.path, decoded, most_faces );
    return copy_indices( gltf, json.path, *out );
}

// The attributes of the extension of a primitive, and its mesh; NULL where it is not compressed.
static RfResult open_packed( RfGltf* gltf, const RfField* primitive, RfField* attributes, RfGltfUnpackedView** mesh )
{
    int64_t mode = 4;
    *mesh = NULL;
    RfField extension = rf_gltf_extension( primitive, EXTENSION );
    if ( extension.json == NULL )
        return rf_json_result( primitive );
    rf_get_integer( primitive, "mode", 4, 5, &mode );
    rf_gltf_require( &extension, "bufferView", NULL );
    int view = rf_gltf_get_index( gltf, &extension, "bufferView", RF_GLTF_BUFFER_VIEWS );
    rf_gltf_require( &extension, "attributes", NULL );
    *attributes = rf_get_object( &extension, "attributes" );
    return rf_json_result( primitive ) == RF_OK ? open_mesh( gltf, view, mesh ) : rf_json_result( primitive );
}

// Reads what the accessor of the file says of attribute `from` of a mesh, and copies its values as that.
static RfResult copy_attribute( RfGltf* gltf, int declared, RfGltfUnpackedView* mesh, int from, RfGltfAccessor* out )
{
    RfField json = rf_gltf_item_field( gltf, RF_GLTF_ACCESSORS, declared );
    RfGltfAccessor layout = { 0 };
    RF_TRY( rf_gltf_read_layout( gltf, &json, false, &layout ) );
    if ( rf_has_member( &json, "sparse" ) )
        return rf_field_fail( &json, "is sparse, and that of a compressed mesh" );
    uint32_t points = rf_draco_points( mesh->mesh );
    int components = rf_draco_components( mesh->mesh, from );
    if ( components != layout.components )
        return rf_field_fail( &json, "has elements of %d numbers, its compressed mesh of %d", layout.components, components );
    uint64_t stride = (uint64_t)components * (uint64_t)rf_gltf_component_size( layout.component_type ), bytes = stride * points;
    RF_TRY( rf_gltf_take_room( gltf, json.path, bytes ) );
    if ( points != layout.count )
        rf_gltf_notice( gltf, "%s has a count of %u, its compressed mesh %u vertices, which are taken", json.path, layout.count,
                        points );
    uint8_t* values;
    RF_TRY( rf_gltf_allocate( gltf, json.path, &values, bytes, sizeof *values ) );
    mesh->attributes[from].values = values;
    if ( !rf_draco_copy( mesh->mesh, from, layout.component_type, values ) )
        return rf_field_fail( &json, "its compressed mesh has numbers that are not of its componentType" );
    *out = layout;
    out->open = true;
    out->count = points;
    out->data = values;
    out->stride = stride;
    out->declared = declared;
    return RF_OK;
}

static RfResult find_packed( RfGltf* gltf, const char* where, const char* name, int64_t id, RfGltfUnpackedView* mesh, int* index )
{
    int from = rf_draco_find( mesh->mesh, (uint32_t)id ), declared = *index;
    if ( from < 0 )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "%s has the id %lld, which its compressed mesh has not", name,
                             (long long)id );
    RfGltfUnpackedAttribute* attribute = mesh->attributes + from;
    if ( attribute->accessor == 0 )
    {
        RF_TRY( copy_attribute( gltf, declared, mesh, from, gltf->accessors + gltf->accessor_count ) );
        attribute->accessor = gltf->accessor_count++;
    }
    *index = attribute->accessor;
    // another primitive may give the same values by an accessor of its own
    const RfGltfAccessor* accessor = gltf->accessors + *index;
    RfGltfAccessor layout = { 0 };
    RfField self = rf_gltf_item_field( gltf, RF_GLTF_ACCESSORS, declared );
    RF_TRY( rf_gltf_read_layout( gltf, &self, false, &layout ) );
    if ( ( layout.component_type == accessor->component_type && layout.normalized == accessor->normalized &&
           layout.components == accessor->components ) )
        return RF_OK;
    return rf_field_fail( &self, "is of the same compressed mesh as accessors[%d], but another type", accessor->declared );
}

RfResult rf_gltf_find_attribute( RfGltf* gltf, const RfField* primitive, const char* name, int* index )
{
    RfField packed, attributes = rf_get_object( primitive, "attributes" );
    RfGltfUnpackedView* mesh = NULL;
    int64_t id = -1;
    *index = rf_gltf_get_index( gltf, &attributes, name, RF_GLTF_ACCESSORS );
    RfResult result = *index >= 0 ? open_packed( gltf, primitive, &packed, &mesh ) : rf_json_result( primitive );
    if ( result == RF_OK && mesh != NULL )
        result = rf_get_integer( &packed, name, 0, UINT32_MAX, &id );
    return result == RF_OK && id >= 0 ? find_packed( gltf, attributes.path, name, id, mesh, index ) : result;
}

RfResult rf_gltf_packed_indices( RfGltf* gltf, const RfField* primitive, const RfGltfAccessor** indices )
{
    RfField attributes;
    RfGltfUnpackedView* mesh;
    RfResult result = open_packed( gltf, primitive, &attributes, &mesh );
    *indices = result == RF_OK && mesh != NULL ? &mesh->indices : NULL;
    return result;
}

size_t rf_gltf_count_packed( const RfGltf* gltf )
{
    size_t count = 0;
    for ( int i = 0; i < gltf->counts[RF_GLTF_MESHES]; ++i )
    {
        const json_t *primitives = json_object_get( rf_gltf_item( gltf, RF_GLTF_MESHES, i ), "primitives" ), *primitive;
        size_t k;
        json_array_foreach( primitives, k, primitive )
        {
            const json_t* extension = json_object_get( json_object_get( primitive, "extensions" ), EXTENSION );
            count += json_object_size( json_object_get( extension, "attributes" ) );
        }
    }
    return count;
}

#else

static void free_mesh( RfGltfUnpackedView* view ) { (void)view; } // there are none

size_t rf_gltf_count_packed( const RfGltf* gltf )
{
    (void)gltf;
    return 0;
}

RfResult rf_gltf_packed_indices( RfGltf* gltf, const RfField* primitive, const RfGltfAccessor** indices )
{
    (void)gltf, (void)primitive;
    *indices = NULL;
    return RF_OK;
}

RfResult rf_gltf_find_attribute( RfGltf* gltf, const RfField* primitive, const char* name, int* index )
{
    RfField attributes = rf_get_object( primitive, "attributes" ), extension = rf_gltf_extension( primitive, EXTENSION );
    *index = rf_gltf_get_index( gltf, &attributes, name, RF_GLTF_ACCESSORS );
    if ( *index < 0 || extension.json == NULL ||
         json_object_get( rf_gltf_item( gltf, RF_GLTF_ACCESSORS, *index ), "bufferView" ) != NULL )
        return rf_json_result( primitive );
    return rf_gltf_fail_left_out( gltf, attributes.path, EXTENSION, "Draco" );
}

#endif

void rf_gltf_free_unpacked( RfGltf* gltf )
{
    for ( int i = 0; gltf->unpacked != NULL && i < gltf->counts[RF_GLTF_BUFFER_VIEWS]; ++i )
    {
        free_mesh( gltf->unpacked->views + i );
        free( gltf->unpacked->views[i].bytes );
    }
    free( gltf->unpacked );
}
