// Cameras and lights from assimp's scene, with the angles and units that each format means.
#include "base/file.h"
#include "import/assimp_import.h"

#include <assimp/version.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    int node = rf_import_add_node( import, &from->mName, find_node( model, from->mName.data ), &matrix );
    if ( node < 0 )
        return;
    if ( import->format == RF_SOURCE_FBX )
        rf_warn( import->log, "camera '%s': its field of view is taken as %.4g degrees across: compare it with the source",
                 from->mName.data, horizontal_angle( import, from ) * 180.0 / PI );
    model->cameras[model->camera_count++] =
        ( RfModelCamera ){ .name = rf_import_text( &from->mName ), .yfov = yfov, .node = node };
}

void rf_import_cameras( RfImport* import )
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
    light.node = rf_import_add_node( import, &from->mName, find_node( model, from->mName.data ), &matrix );
    if ( light.node < 0 )
        return false;
    light.name = rf_import_text( &from->mName );
    model->lights[model->light_count++] = light;
    return true;
}

void rf_import_lights( RfImport* import )
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
