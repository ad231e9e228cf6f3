#include "import/assimp_import.h"

#include <assimp/material.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static float clamp01( float value )
{
    return value > 0.0f ? value < 1.0f ? value : 1.0f : 0.0f; // 0 for NaN
}

// OBJ and PLY colours are sRGB; other formats do not specify it and are taken as linear.
static float to_linear( float c, RfSourceFormat format )
{
    c = clamp01( c );
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
        out[4 * i + 3] = clamp01( c->a );
    }
    return out;
}

static bool has_texture( const RfModel* model, int material )
{
    if ( material < 0 )
        return false;
    const RfModelMaterial* m = model->materials + material;
    return m->base_color_image >= 0 || m->normal_image >= 0 || m->emissive_image >= 0;
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
        count += from->mFaces[i].mNumIndices == 3;
    return count;
}

static bool take_mesh( RfImport* import, const struct aiMesh* from, RfModelMesh* mesh )
{
    uint32_t count = from->mNumVertices;
    *mesh = ( RfModelMesh ){ .name = rf_import_text( &from->mName ), .vertex_count = count, .material = -1 };
    if ( from->mMaterialIndex < (unsigned)import->model->material_count )
        mesh->material = (int)from->mMaterialIndex;
    mesh->positions = malloc( 3 * (size_t)count * sizeof( float ) );
    mesh->indices = malloc( 3 * (size_t)from->mNumFaces * sizeof( uint32_t ) );
    bool good = mesh->positions != NULL && mesh->indices != NULL;
    for ( size_t i = 0; good && i < count; ++i )
    {
        mesh->positions[3 * i] = from->mVertices[i].x;
        mesh->positions[3 * i + 1] = from->mVertices[i].y;
        mesh->positions[3 * i + 2] = from->mVertices[i].z;
    }
    for ( size_t i = 0; good && i < from->mNumFaces; ++i )
    {
        if ( from->mFaces[i].mNumIndices == 3 )
            memcpy( mesh->indices + 3 * (size_t)mesh->triangle_count++, from->mFaces[i].mIndices, 3 * sizeof( uint32_t ) );
    }
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
        good = ( mesh->colors = copy_colors( from, count, import->format ) ) != NULL;
        whiten_default( import->model, mesh->material );
    }
    return good;
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
    {
        const struct aiMesh* from = scene->mMeshes[i];
        import->meshes[i] = -1;
        uint32_t triangles = count_triangles( from );
        dropped += from->mNumFaces > 0 ? from->mNumFaces - triangles : from->mNumVertices;
        if ( triangles == 0 )
            continue;
        import->meshes[i] = model->mesh_count;
        if ( !take_mesh( import, from, model->meshes + model->mesh_count++ ) )
            return rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
    }
    if ( dropped > 0 )
        rf_warn( import->log, "%llu points and lines are left out: only surfaces are rendered", dropped );
    return RF_OK;
}
