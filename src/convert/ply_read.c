#include "convert/ply_read.h"

#include "base/file.h"
#include "convert/ply_reader.h"

#include <stdlib.h>
#include <string.h>

#define MAX_FILE_BYTES ( (uint64_t)64 << 30 )
// Steps for triangulating polygons: enough for about a second per file. Every corner read adds
// more (ply_faces.c), so that no number of ordinary faces exhausts them.
#define CUT_STEPS ( (uint64_t)1 << 28 )

static RfResult skip_element( RfPlyReader* r, const RfPlyElement* element )
{
    RfResult result = RF_OK;
    uint64_t count = element->property_count > 0 ? element->count : 0;
    for ( uint64_t i = 0; result == RF_OK && i < count; ++i )
    {
        for ( int k = 0; result == RF_OK && k < element->property_count; ++k )
            result = rf_ply_skip( &r->file, element->properties + k );
    }
    return result;
}

static RfResult read_elements( RfPlyReader* r )
{
    RfResult result = rf_ply_read_header( &r->file );
    for ( int e = 0; result == RF_OK && e < r->file.element_count; ++e )
    {
        const RfPlyElement* element = r->file.elements + e;
        result = rf_ply_check_element( &r->file, element );
        if ( result != RF_OK )
            break;
        if ( strcmp( element->name, "vertex" ) == 0 )
            result = rf_ply_read_vertices( r, element );
        else if ( strcmp( element->name, "face" ) == 0 )
            result = rf_ply_read_faces( r, element );
        else if ( strcmp( element->name, "tristrips" ) == 0 )
            result = rf_ply_read_strips( r, element );
        else
            result = skip_element( r, element );
    }
    if ( result == RF_OK )
        result = rf_ply_check_end( &r->file );
    if ( result == RF_OK && r->mesh->triangle_count == 0 )
        return rf_fail( r->file.error, RF_ERROR_FORMAT, "%s: has no faces: points alone cannot be rendered, make a mesh of them",
                        r->file.path );
    return result;
}

static RfResult make_model( RfModel* model )
{
    model->meshes = calloc( 1, sizeof *model->meshes );
    model->nodes = calloc( 1, sizeof *model->nodes );
    model->materials = malloc( sizeof *model->materials );
    int* meshes = calloc( 1, sizeof *meshes );
    if ( model->meshes == NULL || model->nodes == NULL || model->materials == NULL || meshes == NULL )
    {
        free( meshes );
        return RF_ERROR_MEMORY;
    }
    model->mesh_count = model->node_count = model->material_count = 1;
    *model->materials = rf_default_model_material(); // glTF's own default material is a white metal
    *model->nodes = ( RfModelNode ){ .parent = -1, .matrix = rf_mat4_identity(), .mesh_count = 1, .meshes = meshes };
    return RF_OK;
}

RfResult rf_read_ply( const char* path, RfModel* model, RfLog* log, RfError* error )
{
    *model = ( RfModel ){ 0 };
    RfPlyReader* r = calloc( 1, sizeof *r ); // on the heap, since its tables are large
    uint8_t* bytes = NULL;
    if ( r == NULL || make_model( model ) != RF_OK )
    {
        free( r );
        rf_destroy_model( model );
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left to read it", path );
    }
    r->file = ( RfPlyFile ){ .path = path, .error = error };
    r->log = log;
    r->cut_steps = CUT_STEPS;
    r->mesh = model->meshes;
    RfResult result = rf_read_file( path, MAX_FILE_BYTES, &bytes, &r->file.size, error );
    r->file.bytes = bytes;
    if ( result == RF_OK )
        result = read_elements( r );
    if ( result == RF_OK )
        rf_ply_finish_vertices( r );
    free( bytes );
    free( r->corners );
    free( r->cut );
    free( r );
    if ( result != RF_OK )
        rf_destroy_model( model );
    return result;
}
