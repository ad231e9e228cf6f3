// From assimp's scene to a model (files, nodes, meshes), and the program around it,
//
//     reframe-import FILE BYTES SECONDS y|z SCALE accept|refuse
//
// which writes FILE as .glb to standard output. Started by `reframe convert`. It limits its own memory and time, so that whatever
// a file does to assimp affects only this process.
#include "import/assimp_import.h"

#include "base/file.h"
#include "base/remedy.h"
#include "base/try.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/version.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

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

static int import_add_node( RfImport* import, const struct aiString* name, int parent, const RfMat4* matrix )
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
    int index = import_add_node( import, &from->mName, parent, &matrix );
    if ( index < 0 || !take_meshes( import, from, import->model->nodes + index ) )
        return false;
    for ( unsigned i = 0; i < from->mNumChildren; ++i )
    {
        if ( !take_node( import, from->mChildren[i], index ) )
            return false;
    }
    return true;
}

static RfResult import_nodes( RfImport* import, RfError* error )
{
    if ( take_node( import, import->scene->mRootNode, -1 ) )
        return RF_OK;
    return rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
}

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

static RfResult import_meshes( RfImport* import, RfError* error )
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

static RfSourceFormat format_of( const char* path )
{
    const char* dot = strrchr( path, '.' );
    if ( dot == NULL )
        return RF_SOURCE_OTHER;
    static const struct
    {
        const char* ending;
        RfSourceFormat format;
    } all[] = { { ".obj", RF_SOURCE_OBJ },
                { ".ply", RF_SOURCE_PLY },
                { ".dae", RF_SOURCE_COLLADA },
                { ".zae", RF_SOURCE_COLLADA },
                { ".fbx", RF_SOURCE_FBX } };
    for ( size_t i = 0; i < sizeof all / sizeof all[0]; ++i )
    {
        if ( strcasecmp( dot, all[i].ending ) == 0 )
            return all[i].format;
    }
    return RF_SOURCE_OTHER;
}

char* rf_import_text( const struct aiString* text ) { return text->length > 0 ? strdup( text->data ) : NULL; }

// Triangles in metres; points and lines go to separate meshes, which are counted and dropped.
// FBX pivots are merged into one node each.
static const struct aiScene* read_file( const char* path )
{
    struct aiPropertyStore* store = aiCreatePropertyStore();
    if ( store == NULL )
        return NULL;
    aiSetImportPropertyInteger( store, AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, 0 );
    const struct aiScene* scene = aiImportFileExWithProperties(
        path, aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_SortByPType | aiProcess_GlobalScale, NULL,
        store );
    aiReleasePropertyStore( store );
    return scene;
}

static RfResult fail_import( const char* reason, RfError* error )
{
    if ( strstr( reason, "No suitable reader" ) != NULL )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "unknown format: OBJ, PLY, FBX and Collada are converted" );
    return rf_fail( error, RF_ERROR_FORMAT, "cannot be read (%s): export it as glTF (.glb) from the program it came from",
                    *reason != 0 ? reason : "the importer gives no reason" );
}

// A whole number among what the file says of itself; `otherwise` where it is not there.
static int number_of_file( const struct aiScene* scene, const char* name, int otherwise )
{
    const struct aiMetadata* data = scene->mMetaData;
    for ( unsigned i = 0; data != NULL && i < data->mNumProperties; ++i )
    {
        const struct aiMetadataEntry* entry = data->mValues + i;
        if ( strcmp( data->mKeys[i].data, name ) == 0 && entry->mType == AI_INT32 && entry->mData != NULL )
            memcpy( &otherwise, entry->mData, sizeof otherwise );
    }
    return otherwise;
}

// assimp turns Collada files to y up; FBX files only from 5.4 on, by a rotation of the root. That is taken out: whether z
// is up in the file is the user's to say, who has other formats too.
static void leave_fbx_axes( RfImport* import )
{
    static const char* const names[3][2] = { { "CoordAxis", "CoordAxisSign" },
                                             { "UpAxis", "UpAxisSign" },
                                             { "FrontAxis", "FrontAxisSign" } };
    if ( import->format != RF_SOURCE_FBX )
        return;
    if ( number_of_file( import->scene, "UpAxis", 1 ) == 2 )
        rf_warn( import->log, "its z points up: unless that is given already, convert it with z up" );
    if ( 100 * aiGetVersionMajor() + aiGetVersionMinor() < 504 )
        return;
    float back[3][3] = { { 0 } }; // its rows are the columns of assimp's rotation, whose rows are these axes
    for ( int i = 0; i < 3; ++i )
    {
        int axis = number_of_file( import->scene, names[i][0], i );
        if ( axis < 0 || axis > 2 )
            return;
        back[axis][i] = number_of_file( import->scene, names[i][1], 1 ) < 0 ? -1.0f : 1.0f;
    }
    float* m = &import->scene->mRootNode->mTransformation.a1;
    for ( int row = 0; row < 3; ++row, m += 4 )
    {
        const float old[3] = { m[0], m[1], m[2] };
        for ( int i = 0; i < 3; ++i )
            m[i] = old[0] * back[0][i] + old[1] * back[1][i] + old[2] * back[2][i];
    }
}

#define PI 3.14159265358979323846

static int find_node( const RfModel* model, const char* name )
{
    for ( int i = 0; i < model->node_count; ++i )
    {
        if ( model->nodes[i].name != NULL && strcmp( model->nodes[i].name, name ) == 0 )
            return i;
    }
    return -1;
}

static bool set_unit( double* v )
{
    double length = sqrt( v[0] * v[0] + v[1] * v[1] + v[2] * v[2] );
    if ( !( length > 1e-9 ) || !isfinite( length ) )
        return false;
    for ( int i = 0; i < 3; ++i )
        v[i] /= length;
    return true;
}

static void cross( const double* a, const double* b, double* out )
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

// glTF's cameras and lights point along −z: a frame whose −z is `look`.
static bool look_matrix( const struct aiVector3D* look, const struct aiVector3D* up, RfMat4* matrix )
{
    double forward[3] = { look->x, look->y, look->z }, above[3] = { up->x, up->y, up->z }, right[3];
    if ( !set_unit( forward ) )
        return false;
    cross( forward, above, right );
    if ( !set_unit( right ) )
    {
        // any up direction will do for a light
        double other[3] = { fabs( forward[0] ) < 0.5, fabs( forward[0] ) >= 0.5, 0 };
        cross( forward, other, right );
        if ( !set_unit( right ) )
            return false;
    }
    cross( right, forward, above );
    *matrix = rf_mat4_identity();
    for ( int i = 0; i < 3; ++i )
    {
        matrix->m[i] = right[i];
        matrix->m[4 + i] = above[i];
        matrix->m[8 + i] = -forward[i];
    }
    return true;
}

static int count_words( const char* text, const char* word )
{
    int count = 0;
    for ( const char* at = strstr( text, word ); at != NULL; at = strstr( at + 1, word ) )
        ++count;
    return count;
}

// Collada has any two of xfov, yfov and aspect_ratio. assimp computes the angle correctly only
// if the ratio is given, and does not report whether it is.
static bool has_aspect_ratios( const RfImport* import )
{
    uint8_t* bytes;
    size_t size;
    if ( rf_read_file( import->path, 1ull << 30, &bytes, &size, NULL ) != RF_OK )
        return false;
    char* text = realloc( bytes, size + 1 );
    if ( text != NULL )
        text[size] = 0;
    bool all = text != NULL && count_words( text, "<perspective" ) <= count_words( text, "<aspect_ratio" );
    free( text != NULL ? (void*)text : (void*)bytes );
    return all;
}

// The horizontal field of view. assimp gives FBX cameras half of it from 5.3 on.
static double horizontal_angle( const RfImport* import, const struct aiCamera* from )
{
    bool is_half = import->format == RF_SOURCE_FBX && 100 * aiGetVersionMajor() + aiGetVersionMinor() >= 503;
    return ( is_half ? 2.0 : 1.0 ) * (double)from->mHorizontalFOV;
}

// The vertical field of view, or 0 if unknown. assimp's is that of Collada and FBX; for some other
// formats it is half of the angle, so these are ignored.
static double vertical_angle( const RfImport* import, const struct aiCamera* from, bool aspects )
{
    double whole = horizontal_angle( import, from ), aspect = (double)from->mAspect;
    bool known = import->format == RF_SOURCE_FBX || ( import->format == RF_SOURCE_COLLADA && aspects );
    if ( !known || from->mOrthographicWidth > 0.0f || !( whole > 0.0 && whole < PI ) || !( aspect > 0.01 && aspect < 100.0 ) )
        return 0.0;
    return 2.0 * atan( tan( 0.5 * whole ) / aspect );
}

static void take_camera( RfImport* import, const struct aiCamera* from, bool aspects )
{
    RfModel* model = import->model;
    double yfov = vertical_angle( import, from, aspects );
    RfMat4 matrix;
    if ( yfov <= 0.0 || !look_matrix( &from->mLookAt, &from->mUp, &matrix ) )
    {
        rf_warn( import->log, "camera '%s': is left out: its field of view is unknown: set it in a scene file",
                 from->mName.data );
        return;
    }
    // The node already has the position: mPosition repeats it for some formats.
    int node = import_add_node( import, &from->mName, find_node( model, from->mName.data ), &matrix );
    if ( node < 0 )
        return;
    if ( import->format == RF_SOURCE_FBX )
        rf_warn( import->log, "camera '%s': its field of view is taken as %.4g degrees across: compare it with the source",
                 from->mName.data, horizontal_angle( import, from ) * 180.0 / PI );
    model->cameras[model->camera_count++] =
        ( RfModelCamera ){ .name = rf_import_text( &from->mName ), .yfov = yfov, .node = node };
}

// Imports the cameras, each on a new node below the node of its name.
static void import_cameras( RfImport* import )
{
    const struct aiScene* scene = import->scene;
    if ( scene->mNumCameras == 0 )
        return;
    import->model->cameras = calloc( scene->mNumCameras, sizeof *import->model->cameras );
    bool aspects = import->format == RF_SOURCE_COLLADA && has_aspect_ratios( import );
    for ( unsigned i = 0; import->model->cameras != NULL && i < scene->mNumCameras; ++i )
        take_camera( import, scene->mCameras[i], aspects );
}

// Splits the colour into a colour of at most 1 and an intensity.
static void set_light_color( RfModelLight* light, const struct aiColor3D* color )
{
    float values[3] = { color->r, color->g, color->b }, most = 0.0f;
    for ( int i = 0; i < 3; ++i )
    {
        values[i] = values[i] > 0.0f && isfinite( values[i] ) ? values[i] : 0.0f;
        most = fmaxf( most, values[i] );
    }
    light->intensity = most;
    for ( int i = 0; i < 3; ++i )
        light->color[i] = most > 0.0f ? values[i] / most : 0.0f;
}

// Both formats give the full angle of a cone, glTF the half angle. Collada has a single angle,
// which assimp stores as the inner one; its outer one is invented.
static void set_cone( RfModelLight* light, const struct aiLight* from, RfSourceFormat format )
{
    float outer = 0.5f * from->mAngleOuterCone, inner = 0.5f * from->mAngleInnerCone;
    if ( format == RF_SOURCE_COLLADA )
        outer = inner;
    if ( !( outer > 1e-3f ) || outer > 1.5707963f )
        outer = outer > 1.5707963f ? 1.5707963f : 0.7853982f;
    if ( !( inner >= 0.0f ) || inner >= outer )
        inner = 0.999f * outer;
    light->inner_angle = inner;
    light->outer_angle = outer;
}

static bool take_light( RfImport* import, const struct aiLight* from )
{
    RfModel* model = import->model;
    RfModelLight light = { .kind = RF_MODEL_POINT };
    if ( from->mType == aiLightSource_SPOT )
        light.kind = RF_MODEL_SPOT;
    else if ( from->mType == aiLightSource_DIRECTIONAL )
        light.kind = RF_MODEL_DIRECTIONAL;
    else if ( from->mType != aiLightSource_POINT )
        return false;
    RfMat4 matrix = rf_mat4_identity();
    if ( light.kind != RF_MODEL_POINT && !look_matrix( &from->mDirection, &from->mUp, &matrix ) )
        return false;
    set_light_color( &light, &from->mColorDiffuse );
    if ( light.kind == RF_MODEL_SPOT )
        set_cone( &light, from, import->format );
    light.node = import_add_node( import, &from->mName, find_node( model, from->mName.data ), &matrix );
    if ( light.node < 0 )
        return false;
    light.name = rf_import_text( &from->mName );
    model->lights[model->light_count++] = light;
    return true;
}

static void import_lights( RfImport* import )
{
    const struct aiScene* scene = import->scene;
    RfModel* model = import->model;
    if ( scene->mNumLights == 0 )
        return;
    model->lights = calloc( scene->mNumLights, sizeof *model->lights );
    for ( unsigned i = 0; model->lights != NULL && i < scene->mNumLights; ++i )
    {
        if ( !take_light( import, scene->mLights[i] ) )
            rf_warn( import->log, "light '%s': is left out: it is not a point, spot or directional light",
                     scene->mLights[i]->mName.data );
    }
    if ( model->light_count > 0 )
        rf_warn( import->log, "the strength of %d lights is the file's number as candela or lux: compare it with the source",
                 model->light_count );
}

static RfResult take_all( RfImport* import, RfError* error )
{
    leave_fbx_axes( import );
    RF_TRY( rf_import_materials( import, error ) );
    if ( import->lost[0] != 0 && !import->accepts_losses )
        return rf_advise( rf_fail( error, RF_ERROR_IO, "%s", import->lost ), RF_REMEDY_ACCEPT_LOSSES, 0, error );
    RF_TRY( import_meshes( import, error ) );
    RF_TRY( import_nodes( import, error ) );
    import_cameras( import );
    import_lights( import );
    if ( import->scene->mNumAnimations > 0 )
        rf_warn( import->log, "%u animations are left out: only static geometry is converted", import->scene->mNumAnimations );
    if ( import->model->mesh_count == 0 )
        return rf_fail( error, RF_ERROR_SCENE, "has no triangles: nothing to convert" );
    return RF_OK;
}

// Imports a whole file. Messages do not name the file: the caller does.
static RfResult import_by_assimp( const char* path, bool accepts_losses, RfModel* model, RfLog* log, RfError* error )
{
    RfImport import = { .path = path, .format = format_of( path ), .model = model, .log = log, .accepts_losses = accepts_losses };
    import.scene = read_file( path );
    if ( import.scene == NULL )
        return fail_import( aiGetErrorString(), error );
    if ( import.scene->mRootNode == NULL )
        return fail_import( "it is empty", error );
    import.meshes = malloc( ( (size_t)import.scene->mNumMeshes + 1 ) * sizeof *import.meshes );
    RfResult result = import.meshes == NULL ? rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY ) : take_all( &import, error );
    free( import.meshes );
    free( import.image_names );
    aiReleaseImport( import.scene );
    return result;
}

#define _DEFAULT_SOURCE // setrlimit, prctl

#include "import/assimp_import.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#define WARNING_LIMIT 16

static void set_limit( int resource, unsigned long long value )
{
    struct rlimit limit;
    if ( getrlimit( resource, &limit ) != 0 )
        return;
    if ( limit.rlim_max == RLIM_INFINITY || value < limit.rlim_max )
        limit.rlim_max = value;
    limit.rlim_cur = limit.rlim_max;
    setrlimit( resource, &limit );
}

static void set_limits( unsigned long long bytes, unsigned long long seconds )
{
    prctl( PR_SET_PDEATHSIG, SIGKILL );
    set_limit( RLIMIT_CORE, 0 );
    set_limit( RLIMIT_CPU, seconds + 1 );
#ifndef REFRAME_SANITIZED // sanitizers reserve terabytes of address space
    set_limit( RLIMIT_AS, bytes );
#else
    (void)bytes;
#endif
}

static void print_warning( void* user, const char* line )
{
    int* count = user;
    if ( ++*count < WARNING_LIMIT )
        fprintf( stderr, "warning: %s\n", line );
    else if ( *count == WARNING_LIMIT )
        fprintf( stderr, "warning: and more of the kind\n" );
}

static void print_counts( const RfModel* model )
{
    RfModelCounts c = rf_count_model( model );
    fprintf( stderr, "counts: %llu %d %d %d %d %d %d\n", c.triangles, c.meshes, c.nodes, c.materials, c.images, c.cameras,
             c.lights );
}

static RfResult import_to( RfAtomicFile* out, char** argv, RfError* error )
{
    RfModel model = { 0 };
    int warnings = 0;
    RfLog log = { .fn = print_warning, .user = &warnings };
    double scale;
    unsigned long long bits = strtoull( argv[5], NULL, 16 );
    memcpy( &scale, &bits, sizeof scale );
    RfResult result = import_by_assimp( argv[1], strcmp( argv[6], "accept" ) == 0, &model, &log, error );
    if ( result == RF_OK )
        result = rf_apply_root_transform( &model, argv[4][0] == 'z', scale, error );
    if ( result == RF_OK )
        result = rf_append_glb( out, &model, error );
    if ( result == RF_OK )
        print_counts( &model );
    rf_destroy_model( &model );
    return result;
}

int main( int argc, char** argv )
{
    if ( argc != 7 )
    {
        fprintf( stderr, "error: reframe-import is started by reframe convert, not by hand\n" );
        return 2;
    }
    set_limits( strtoull( argv[2], NULL, 10 ), strtoull( argv[3], NULL, 10 ) );
    // keeps assimp's own output out of the result
    RfAtomicFile out = { .path = "its .glb", .fd = dup( 1 ), .folder = -1 };
    int nothing = open( "/dev/null", O_WRONLY );
    if ( out.fd < 0 || nothing < 0 || dup2( nothing, 1 ) < 0 )
        return 1;
    RfError error;
    if ( import_to( &out, argv, &error ) == RF_OK )
        return 0;
    fprintf( stderr, "%s: %s\n", error.remedy == RF_REMEDY_ACCEPT_LOSSES ? "lost" : "error", error.text );
    return 1;
}
