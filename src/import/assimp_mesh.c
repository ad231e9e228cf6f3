// Nodes and meshes of assimp's scene.
#include "import/assimp_import.h"

#include "base/try.h"

#include <assimp/material.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// OBJ and PLY colours are sRGB; other formats do not specify it and are taken as linear.
static float to_linear( float c, RfSourceFormat format )
{
    c = rf_clamp01( c );
    if ( format != RF_SOURCE_OBJ && format != RF_SOURCE_PLY )
        return c;
    return c <= 0.04045f ? c / 12.92f : powf( ( c + 0.055f ) / 1.055f, 2.4f );
}

static float* copy_normals( const struct aiMesh* from, const RfModelMesh* mesh )
{
    float* out = malloc( 3 * (size_t)mesh->vertex_count * sizeof *out );
    for ( size_t i = 0; out != NULL && i < mesh->vertex_count; ++i )
    {
        double x = from->mNormals[i].x, y = from->mNormals[i].y, z = from->mNormals[i].z;
        double length = sqrt( x * x + y * y + z * z );
        if ( !( length > 1e-12 ) || !isfinite( length ) )
        {
            // a zero-length normal: dropping all normals gives flat shading, which is at least correct
            free( out );
            return NULL;
        }
        out[3 * i] = (float)( x / length );
        out[3 * i + 1] = (float)( y / length );
        out[3 * i + 2] = (float)( z / length );
    }
    return out;
}

// Zeros if the material has a texture but the mesh no coordinates, which glTF requires.
static float* copy_uvs( const struct aiMesh* from, uint32_t count )
{
    float* out = calloc( 2 * (size_t)count, sizeof *out );
    for ( size_t i = 0; out != NULL && from->mTextureCoords[0] != NULL && i < count; ++i )
    {
        out[2 * i] = from->mTextureCoords[0][i].x;
        out[2 * i + 1] = 1.0f - from->mTextureCoords[0][i].y; // v points down in glTF
    }
    return out;
}

static float* copy_colors( const struct aiMesh* from, uint32_t count, RfSourceFormat format )
{
    float* out = malloc( 4 * (size_t)count * sizeof *out );
    for ( size_t i = 0; out != NULL && i < count; ++i )
    {
        const struct aiColor4D* c = from->mColors[0] + i;
        out[4 * i] = to_linear( c->r, format );
        out[4 * i + 1] = to_linear( c->g, format );
        out[4 * i + 2] = to_linear( c->b, format );
        out[4 * i + 3] = rf_clamp01( c->a );
    }
    return out;
}

static bool has_texture( const RfModel* model, int material )
{
    if ( material < 0 )
        return false;
    const RfModelMaterial* m = model->materials + material;
    return m->base_color_texture.image >= 0 || m->normal_texture.image >= 0 || m->emissive_texture.image >= 0;
}

// The default material that assimp invents is grey and would darken the vertex colours, which
// it multiplies.
static void whiten_default( RfModel* model, int material )
{
    RfModelMaterial* m = material >= 0 ? model->materials + material : NULL;
    if ( m != NULL && m->name != NULL && strcmp( m->name, AI_DEFAULT_MATERIAL_NAME ) == 0 )
        m->base_color[0] = m->base_color[1] = m->base_color[2] = 1.0f;
}

// Counts the triangles: degenerate faces that became points and lines may be among them.
static uint32_t count_triangles( const struct aiMesh* from )
{
    uint32_t count = 0;
    for ( uint32_t i = 0; from->mVertices != NULL && i < from->mNumFaces; ++i )
        count += from->mFaces[i].mNumIndices >= 3 ? from->mFaces[i].mNumIndices - 2 : 0;
    return count;
}

// Whether what was noted of a mesh far from its origin is of this one: an FBX file does not say of which its corners are.
static bool is_of( const RfFact* fact, const struct aiMesh* from )
{
    if ( fact->text == NULL )
        return strcmp( fact->name, from->mName.data ) == 0;
    if ( fact->values[3] != (double)from->mNumVertices )
        return false;
    const float* corners = (const float*)fact->text;
    for ( size_t i = 0; i < 3 * (size_t)from->mNumVertices; ++i )
    {
        const struct aiVector3D* p = from->mVertices + i / 3;
        const float found[3] = { p->x, p->y, p->z };
        if ( found[i % 3] != (float)( fact->values[i % 3] + (double)corners[i] ) )
        {
            // the sum was rounded twice
            double step = fabs( fact->values[i % 3] ) * 2e-7;
            if ( !( fabs( (double)found[i % 3] - fact->values[i % 3] - (double)corners[i] ) <= step ) )
                return false;
        }
    }
    return true;
}

// Takes positions that assimp has rounded as the file has them.
static void take_far( RfImport* import, const struct aiMesh* from, RfModelMesh* mesh )
{
    const RfFact* found = NULL;
    double* origin = import->origins[mesh - import->model->meshes];
    for ( int i = 0; i < import->source->fact_count && found == NULL; ++i )
    {
        const RfFact* fact = import->source->facts + i;
        found = fact->kind == RF_FACT_FAR && is_of( fact, from ) ? fact : NULL;
    }
    for ( int k = 0; k < 3 && found != NULL; ++k )
        origin[k] = import->source->unit * found->values[k];
    for ( size_t i = 0; found != NULL && found->text != NULL && i < 3 * (size_t)from->mNumVertices; ++i )
        mesh->positions[i] = (float)( import->source->unit * (double)( (const float*)found->text )[i] );
}

// Triangulates the faces. assimp would leave parts of concave ones out.
static RfResult take_faces( RfImport* import, const struct aiMesh* from, RfModelMesh* mesh, RfError* error )
{
    int crossed = 0;
    for ( unsigned i = 0; i < from->mNumFaces; ++i )
    {
        const struct aiFace* face = from->mFaces + i;
        if ( face->mNumIndices < 3 )
            continue;
        uint32_t* out = mesh->indices + 3 * (size_t)mesh->triangle_count;
        RfCut cut = rf_cut_polygon( mesh->positions, face->mIndices, face->mNumIndices, out, &import->cutter );
        if ( cut == RF_CUT_NO_MEMORY )
            return rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
        if ( cut == RF_CUT_GIVEN_UP )
            return rf_fail( error, RF_ERROR_UNSUPPORTED,
                            "mesh '%s': a face of %u corners takes too long to triangulate: triangulate it first",
                            rf_name_in_file( import->source, from->mName.data ), face->mNumIndices );
        crossed += cut == RF_CUT_CROSSED;
        mesh->triangle_count += face->mNumIndices - 2;
    }
    if ( crossed > 0 )
        rf_warn( import->log, "mesh '%s': %d faces intersect themselves: their triangulation may be wrong",
                 rf_name_in_file( import->source, from->mName.data ), crossed );
    return RF_OK;
}

static RfResult take_mesh( RfImport* import, const struct aiMesh* from, RfModelMesh* mesh, uint32_t triangles, RfError* error )
{
    uint32_t count = from->mNumVertices;
    *mesh = ( RfModelMesh ){ .name = rf_import_text( &from->mName ), .vertex_count = count, .material = -1 };
    if ( from->mMaterialIndex < (unsigned)import->model->material_count )
        mesh->material = (int)from->mMaterialIndex;
    mesh->positions = malloc( 3 * (size_t)count * sizeof( float ) );
    mesh->indices = malloc( 3 * (size_t)triangles * sizeof( uint32_t ) );
    bool good = mesh->positions != NULL && mesh->indices != NULL;
    for ( size_t i = 0; good && i < count; ++i )
    {
        mesh->positions[3 * i] = (float)( import->source->unit * (double)from->mVertices[i].x );
        mesh->positions[3 * i + 1] = (float)( import->source->unit * (double)from->mVertices[i].y );
        mesh->positions[3 * i + 2] = (float)( import->source->unit * (double)from->mVertices[i].z );
    }
    if ( good )
        take_far( import, from, mesh );
    if ( good )
        RF_TRY( take_faces( import, from, mesh, error ) );
    if ( good && from->mNormals != NULL )
    {
        mesh->normals = copy_normals( from, mesh );
        if ( mesh->normals == NULL )
            rf_warn( import->log, "mesh '%s': has normals of length 0: all its normals are left out", from->mName.data );
    }
    bool textured = has_texture( import->model, mesh->material );
    if ( good && ( from->mTextureCoords[0] != NULL || textured ) )
        good = ( mesh->uvs = copy_uvs( from, count ) ) != NULL;
    if ( good && from->mTextureCoords[0] == NULL && textured )
        rf_warn( import->log, "mesh '%s': has a texture and no texture coordinates: it gets one colour", from->mName.data );
    if ( good && from->mColors[0] != NULL )
    {
        good = ( mesh->colors = copy_colors( from, count, import->source->format ) ) != NULL;
        whiten_default( import->model, mesh->material );
    }
    good = good && rf_take_pose( import, from, mesh ) && rf_join_vertices( mesh ) && rf_turn_normals( mesh );
    return good ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
}

// assimp does not check the numbers in some files.
static RfResult check_corners( const struct aiMesh* from, int index, RfError* error )
{
    for ( unsigned i = 0; i < from->mNumFaces; ++i )
    {
        const struct aiFace* face = from->mFaces + i;
        for ( unsigned k = 0; k < face->mNumIndices; ++k )
        {
            if ( face->mIndices[k] >= from->mNumVertices )
                return rf_fail( error, RF_ERROR_FORMAT, "mesh %d '%s': triangle %u: there is no vertex %u", index,
                                from->mName.data, i, face->mIndices[k] );
        }
    }
    return RF_OK;
}

static bool is_target( const struct aiNode* node )
{
    return strncmp( node->mName.data, RF_TARGET_NODE, strlen( RF_TARGET_NODE ) ) == 0;
}

// Notes which meshes nodes have that are seen, as 0.
static void find_used( RfImport* import, const struct aiNode* node )
{
    if ( rf_find_fact( import->source, RF_FACT_HIDDEN, node->mName.data, 0 ) != NULL )
        return;
    for ( unsigned i = 0; i < node->mNumMeshes && !is_target( node ); ++i )
    {
        if ( node->mMeshes[i] < import->scene->mNumMeshes )
            import->meshes[node->mMeshes[i]] = 0;
    }
    for ( unsigned i = 0; i < node->mNumChildren; ++i )
        find_used( import, node->mChildren[i] );
}

RfResult rf_import_meshes( RfImport* import, RfError* error )
{
    const struct aiScene* scene = import->scene;
    RfModel* model = import->model;
    unsigned long long dropped = 0;
    model->meshes = calloc( (size_t)scene->mNumMeshes + 1, sizeof *model->meshes );
    if ( model->meshes == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
    for ( unsigned i = 0; i < scene->mNumMeshes; ++i )
        import->meshes[i] = -1;
    find_used( import, scene->mRootNode );
    for ( unsigned i = 0; i < scene->mNumMeshes; ++i )
    {
        const struct aiMesh* from = scene->mMeshes[i];
        if ( import->meshes[i] < 0 )
            continue;
        import->meshes[i] = -1;
        uint32_t triangles = count_triangles( from );
        for ( unsigned f = 0; f < from->mNumFaces; ++f )
            dropped += from->mFaces[f].mNumIndices < 3;
        dropped += from->mNumFaces == 0 ? from->mNumVertices : 0;
        if ( triangles == 0 )
            continue;
        RF_TRY( check_corners( from, model->mesh_count, error ) );
        import->meshes[i] = model->mesh_count;
        RF_TRY( take_mesh( import, from, model->meshes + model->mesh_count++, triangles, error ) );
    }
    if ( dropped > 0 )
        rf_warn( import->log, "%llu points and lines are left out: only surfaces are rendered", dropped );
    return RF_OK;
}

RfMat4 rf_import_matrix( const RfImport* import, const struct aiMatrix4x4* from )
{
    const float* rows = &from->a1; // 16 numbers, row-major
    RfMat4 out;
    for ( int r = 0; r < 4; ++r )
    {
        for ( int c = 0; c < 4; ++c )
            out.m[4 * c + r] = r < 3 ? (double)rows[4 * r + c] : c == 3;
        out.m[12 + r] *= r < 3 ? import->source->unit : 1.0;
    }
    return out;
}

int rf_import_node( RfImport* import, const char* name, int parent, const RfMat4* matrix )
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
    model->nodes[count] = ( RfModelNode ){ .name = *name != 0 ? strdup( name ) : NULL, .parent = parent, .matrix = *matrix };
    model->node_count += 1;
    return count;
}

int rf_find_import_node( const RfImport* import, const char* name )
{
    const RfModel* model = import->model;
    for ( int i = 0; i < model->node_count; ++i )
    {
        if ( model->nodes[i].name != NULL && strcmp( model->nodes[i].name, name ) == 0 )
            return i;
    }
    return -1;
}

static bool add_posed( RfImport* import, const struct aiNode* from, const struct aiMesh* mesh, int node )
{
    int count = import->posed_count;
    if ( ( count & ( count - 1 ) ) == 0 )
    {
        RfPosed* more = realloc( import->posed, ( count > 0 ? 2 * (size_t)count : 1 ) * sizeof *more );
        if ( more == NULL )
            return false;
        import->posed = more;
    }
    import->posed[import->posed_count++] = ( RfPosed ){ from, mesh, node };
    return true;
}

static bool add_mesh( RfImport* import, int node, int mesh )
{
    RfModelNode* to = import->model->nodes + node;
    int* more = realloc( to->meshes, ( (size_t)to->mesh_count + 1 ) * sizeof *more );
    if ( more == NULL )
        return false;
    to->meshes = more;
    to->meshes[to->mesh_count++] = mesh;
    return true;
}

// Meshes with skins or morph targets get nodes of their own where others are beside them, and those that were moved near their
// origins, that move them back.
static bool take_meshes( RfImport* import, const struct aiNode* from, int node )
{
    for ( unsigned i = 0; i < from->mNumMeshes; ++i )
    {
        RfMat4 place = rf_mat4_identity();
        int mesh = from->mMeshes[i] < import->scene->mNumMeshes ? import->meshes[from->mMeshes[i]] : -1;
        if ( mesh < 0 )
            continue;
        const RfModelMesh* m = import->model->meshes + mesh;
        bool poses = m->skin != NULL || m->morph_count > 0;
        const double* origin = import->origins[mesh];
        bool far = m->skin == NULL && ( origin[0] != 0.0 || origin[1] != 0.0 || origin[2] != 0.0 );
        if ( far )
            memcpy( place.m + 12, origin, 3 * sizeof *origin );
        int to = far || ( poses && from->mNumMeshes > 1 ) ? rf_import_node( import, "", node, &place ) : node;
        if ( to < 0 || !add_mesh( import, to, mesh ) ||
             ( poses && !add_posed( import, from, import->scene->mMeshes[from->mMeshes[i]], to ) ) )
            return false;
    }
    return true;
}

// How far floats are apart at a distance.
static double step_at( double distance ) { return (double)nextafterf( (float)distance, INFINITY ) - (double)(float)distance; }

// The largest coordinate of a mesh, and the mean length of its edges.
static void measure_mesh( const RfModelMesh* mesh, double* far, double* edge )
{
    double sum = 0.0;
    *far = 0.0;
    for ( size_t i = 0; i < 3 * (size_t)mesh->triangle_count; ++i )
    {
        const float *a = mesh->positions + 3 * (size_t)mesh->indices[i],
                    *b = mesh->positions + 3 * (size_t)mesh->indices[i % 3 == 2 ? i - 2 : i + 1];
        double length = 0.0;
        for ( int k = 0; k < 3; ++k )
        {
            length += ( (double)a[k] - (double)b[k] ) * ( (double)a[k] - (double)b[k] );
            *far = fmax( *far, fabs( (double)a[k] ) );
        }
        sum += sqrt( length );
    }
    *edge = mesh->triangle_count > 0 ? sum / ( 3.0 * mesh->triangle_count ) : 0.0;
}

// Names the mesh that rounding to floats, by assimp, harms most: its own positions, and the places of its nodes.
static void name_far( const RfImport* import )
{
    const RfModel* model = import->model;
    double worst = 1.0 / 256.0, worst_far = 0.0;
    const RfModelMesh* found = NULL;
    for ( int n = 0; n < model->node_count; ++n )
    {
        for ( int i = 0; i < model->nodes[n].mesh_count; ++i )
        {
            const RfModelMesh* mesh = model->meshes + model->nodes[n].meshes[i];
            double far, edge, scale = 1.0;
            measure_mesh( mesh, &far, &edge );
            double least = edge, step = step_at( far );
            for ( int up = n; up >= 0; up = model->nodes[up].parent )
            {
                const double* m = model->nodes[up].matrix.m;
                const double* own = import->origins[model->nodes[n].meshes[i]];
                const double* o = up == n && m[12] == own[0] && m[13] == own[1] && m[14] == own[2] ? own // of doubles
                                  : model->nodes[up].parent < 0                                    ? import->source->origin
                                                                                                   : NULL;
                scale *= cbrt( fabs( rf_mat4_det3( &model->nodes[up].matrix ) ) );
                far *= cbrt( fabs( rf_mat4_det3( &model->nodes[up].matrix ) ) );
                step *= cbrt( fabs( rf_mat4_det3( &model->nodes[up].matrix ) ) );
                for ( int k = 0; k < 3; ++k )
                {
                    double place = fabs( m[12 + k] - ( o != NULL ? o[k] : 0.0 ) );
                    far = fmax( far, place );
                    step = fmax( step, step_at( place ) );
                }
            }
            least = edge * scale;
            if ( !( step > worst * least ) || !( step < INFINITY ) || !( least > 0.0 ) )
                continue;
            worst = step / least;
            worst_far = far;
            found = mesh;
        }
    }
    if ( found != NULL )
        rf_warn(
            import->log,
            "mesh '%s': lies %.4g m from the origin of the file, where its positions are rounded to %.2g m: move it near in the "
            "program it came from",
            found->name != NULL ? rf_name_in_file( import->source, found->name ) : "", worst_far, step_at( worst_far ) );
}

#define PIVOT "_$AssimpFbx$_"

static bool is_animated( const RfImport* import, const struct aiNode* node )
{
    for ( unsigned i = 0; i < import->scene->mNumAnimations; ++i )
    {
        const struct aiAnimation* animation = import->scene->mAnimations[i];
        for ( unsigned k = 0; k < animation->mNumChannels; ++k )
        {
            if ( strcmp( animation->mChannels[k]->mNodeName.data, node->mName.data ) == 0 )
                return true;
        }
    }
    return false;
}

// Whether a node is a part of the transformation of an FBX node that can be multiplied into the next part. What moves
// the node itself, the last one of its parts, stands for all of them.
static bool is_still_pivot( const RfImport* import, const struct aiNode* node )
{
    if ( strstr( node->mName.data, PIVOT ) == NULL || node->mNumChildren != 1 || node->mNumMeshes > 0 ||
         is_animated( import, node ) )
        return false;
    const struct aiNode* next = node->mChildren[0];
    return strstr( next->mName.data, PIVOT ) == NULL || !is_animated( import, next );
}

// Recursive: assimp itself overflows the stack first on hierarchies that are too deep.
static bool take_node( RfImport* import, const struct aiNode* from, int parent, const RfMat4* above, bool hidden )
{
    if ( is_target( from ) )
        return true;
    hidden = hidden || rf_find_fact( import->source, RF_FACT_HIDDEN, from->mName.data, 0 ) != NULL;
    RfMat4 own = rf_import_matrix( import, &from->mTransformation ), matrix = rf_mat4_mul( above, &own );
    if ( is_still_pivot( import, from ) )
        return take_node( import, from->mChildren[0], parent, &matrix, hidden );
    int index = rf_import_node( import, from->mName.data, parent, &matrix );
    if ( hidden && from->mNumMeshes > 0 )
    {
        import->hidden += 1;
        import->hidden_name = from->mName.data;
    }
    if ( index < 0 || ( !hidden && !take_meshes( import, from, index ) ) )
        return false;
    const RfMat4 same = rf_mat4_identity();
    for ( unsigned i = 0; i < from->mNumChildren; ++i )
    {
        if ( !take_node( import, from->mChildren[i], index, &same, hidden ) )
            return false;
    }
    return true;
}

RfResult rf_import_nodes( RfImport* import, RfError* error )
{
    RfMat4 origin = rf_mat4_identity();
    memcpy( origin.m + 12, import->source->origin, sizeof import->source->origin );
    if ( !take_node( import, import->scene->mRootNode, -1, &origin, false ) )
        return rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
    if ( import->hidden > 0 )
        rf_warn( import->log, "%d objects are hidden in the file: they are left out, as '%s'", import->hidden,
                 rf_name_in_file( import->source, import->hidden_name ) );
    name_far( import );
    return RF_OK;
}
