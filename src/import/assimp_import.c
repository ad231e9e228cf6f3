#include "import/assimp_import.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/version.h>

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

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

static RfResult take_all( RfImport* import, RfError* error )
{
    leave_fbx_axes( import );
    RfResult result = rf_import_materials( import, error );
    if ( result == RF_OK )
        result = rf_import_meshes( import, error );
    if ( result == RF_OK )
        result = rf_import_nodes( import, error );
    if ( result != RF_OK )
        return result;
    rf_import_cameras( import );
    rf_import_lights( import );
    if ( import->scene->mNumAnimations > 0 )
        rf_warn( import->log, "%u animations are left out: only static geometry is converted", import->scene->mNumAnimations );
    if ( import->model->mesh_count == 0 )
        return rf_fail( error, RF_ERROR_SCENE, "has no triangles: nothing to convert" );
    return RF_OK;
}

RfResult rf_import_by_assimp( const char* path, RfModel* model, RfLog* log, RfError* error )
{
    RfImport import = { .path = path, .format = format_of( path ), .model = model, .log = log };
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
