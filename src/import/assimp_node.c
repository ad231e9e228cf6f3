#include "import/assimp_import.h"

#include <stdlib.h>
#include <string.h>

static RfMat4 matrix_of( const struct aiMatrix4x4* from )
{
    const float* rows = &from->a1; // 16 numbers, row-major
    RfMat4 out;
    for ( int r = 0; r < 4; ++r )
    {
        for ( int c = 0; c < 4; ++c )
            out.m[4 * c + r] = r < 3 ? (double)rows[4 * r + c] : c == 3;
    }
    return out;
}

int rf_import_add_node( RfImport* import, const struct aiString* name, int parent, const RfMat4* matrix )
{
    RfModel* model = import->model;
    int count = model->node_count;
    if ( ( count & ( count - 1 ) ) == 0 ) // full at powers of two
    {
        RfModelNode* more = realloc( model->nodes, ( count > 0 ? 2 * (size_t)count : 1 ) * sizeof *more );
        if ( more == NULL )
            return -1;
        model->nodes = more;
    }
    model->nodes[count] = ( RfModelNode ){ .name = rf_import_text( name ), .parent = parent, .matrix = *matrix };
    model->node_count += 1;
    return count;
}

static bool take_meshes( RfImport* import, const struct aiNode* from, RfModelNode* node )
{
    if ( from->mNumMeshes == 0 )
        return true;
    node->meshes = malloc( (size_t)from->mNumMeshes * sizeof *node->meshes );
    for ( unsigned i = 0; node->meshes != NULL && i < from->mNumMeshes; ++i )
    {
        if ( from->mMeshes[i] < import->scene->mNumMeshes && import->meshes[from->mMeshes[i]] >= 0 )
            node->meshes[node->mesh_count++] = import->meshes[from->mMeshes[i]];
    }
    return node->meshes != NULL;
}

// Recursive: assimp itself overflows the stack first on hierarchies that are too deep.
static bool take_node( RfImport* import, const struct aiNode* from, int parent )
{
    RfMat4 matrix = matrix_of( &from->mTransformation );
    int index = rf_import_add_node( import, &from->mName, parent, &matrix );
    if ( index < 0 || !take_meshes( import, from, import->model->nodes + index ) )
        return false;
    for ( unsigned i = 0; i < from->mNumChildren; ++i )
    {
        if ( !take_node( import, from->mChildren[i], index ) )
            return false;
    }
    return true;
}

RfResult rf_import_nodes( RfImport* import, RfError* error )
{
    if ( take_node( import, import->scene->mRootNode, -1 ) )
        return RF_OK;
    return rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
}
