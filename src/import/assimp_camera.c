// Cameras and lights of assimp's scene.
#include "import/assimp_import.h"

#include <assimp/version.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

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

// The horizontal field of view. assimp gives FBX cameras half of it from 5.3 on.
static double horizontal_angle( const RfImport* import, const struct aiCamera* from )
{
    bool is_half = import->source->format == RF_SOURCE_FBX && 100 * aiGetVersionMajor() + aiGetVersionMinor() >= 503;
    return ( is_half ? 2.0 : 1.0 ) * (double)from->mHorizontalFOV;
}

// The vertical field of view, or 0 if unknown. assimp's is that of FBX; for Collada it depends on what the file gives, and
// for some other formats it is half of the angle, so these are ignored.
static double vertical_angle( const RfImport* import, const struct aiCamera* from, const RfFact* fact, double aspect )
{
    double whole = horizontal_angle( import, from );
    if ( import->source->format == RF_SOURCE_COLLADA )
    {
        double yfov = fact != NULL ? fact->values[RF_CAMERA_YFOV] * PI / 180.0 : 0.0;
        whole = fact != NULL ? fact->values[RF_CAMERA_XFOV] * PI / 180.0 : 0.0;
        if ( yfov > 0.0 && yfov < PI )
            return yfov;
    }
    else if ( import->source->format != RF_SOURCE_FBX )
        return 0.0;
    return whole > 0.0 && whole < PI && aspect > 0.01 && aspect < 100.0 ? 2.0 * atan( tan( 0.5 * whole ) / aspect ) : 0.0;
}

// Half the size of what an orthographic camera sees. FBX does not say of what side its zoom is: taken as the width.
static void set_magnification( const RfImport* import, const RfFact* fact, double aspect, RfModelCamera* camera )
{
    double x = fact->values[RF_CAMERA_XMAG], y = fact->values[RF_CAMERA_YMAG];
    bool known = aspect > 0.01 && aspect < 100.0;
    if ( import->source->format == RF_SOURCE_FBX && known && aspect < 1.0 )
    {
        y = x; // of the longer side
        x = 0.0;
    }
    camera->xmag = x > 0.0 ? x : y * ( known ? aspect : 1.0 );
    camera->ymag = y > 0.0 ? y : x / ( known ? aspect : 1.0 );
}

static void take_camera( RfImport* import, const struct aiCamera* from )
{
    RfModel* model = import->model;
    const char* name = rf_name_in_file( import->source, from->mName.data );
    const RfFact* fact = rf_find_fact( import->source, RF_FACT_CAMERA, from->mName.data, 0 );
    double aspect =
        import->source->format == RF_SOURCE_COLLADA ? fact != NULL ? fact->values[RF_CAMERA_ASPECT] : 0.0 : (double)from->mAspect;
    RfModelCamera camera = { .yfov = vertical_angle( import, from, fact, aspect ) };
    bool flat = fact != NULL && fact->values[RF_CAMERA_ORTHOGRAPHIC] != 0.0;
    if ( flat )
        set_magnification( import, fact, aspect, &camera );
    RfMat4 matrix;
    if ( !( flat ? camera.xmag > 0.0 && isfinite( camera.xmag ) : camera.yfov > 0.0 ) ||
         !look_matrix( &from->mLookAt, &from->mUp, &matrix ) )
    {
        rf_warn( import->log, "camera '%s': is left out: its field of view is unknown: set it in a scene file", name );
        return;
    }
    // The node already has the position: mPosition repeats it for some formats.
    camera.node = rf_import_node( import, from->mName.data, rf_find_import_node( import, from->mName.data ), &matrix );
    if ( camera.node < 0 )
        return;
    if ( import->source->format == RF_SOURCE_FBX && flat )
        rf_warn( import->log, "camera '%s': is orthographic, and its longer side taken as %.4g m: compare it with the source",
                 name, 2.0 * fmax( camera.xmag, camera.ymag ) );
    else if ( import->source->format == RF_SOURCE_FBX )
        rf_warn( import->log, "camera '%s': its field of view is taken as %.4g degrees across: compare it with the source", name,
                 horizontal_angle( import, from ) * 180.0 / PI );
    camera.name = rf_import_text( &from->mName );
    model->cameras[model->camera_count++] = camera;
}

// Imports the cameras, each on a new node below the node of its name.
void rf_import_cameras( RfImport* import )
{
    const struct aiScene* scene = import->scene;
    if ( scene->mNumCameras == 0 )
        return;
    import->model->cameras = calloc( scene->mNumCameras, sizeof *import->model->cameras );
    for ( unsigned i = 0; import->model->cameras != NULL && i < scene->mNumCameras; ++i )
        take_camera( import, scene->mCameras[i] );
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
        set_cone( &light, from, import->source->format );
    light.node = rf_import_node( import, from->mName.data, rf_find_import_node( import, from->mName.data ), &matrix );
    if ( light.node < 0 )
        return false;
    const RfFact* area = rf_find_fact( import->source, RF_FACT_AREA, from->mName.data, 0 );
    if ( area != NULL )
        rf_warn( import->log, "light '%s': is an area light of %.4g x %.4g m, and becomes a point: give it a surface that emits",
                 from->mName.data, area->values[0], area->values[1] );
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
                     rf_name_in_file( import->source, scene->mLights[i]->mName.data ) );
    }
    if ( model->light_count > 0 )
        rf_warn( import->log, "the strength of %d lights is the file's number as candela or lux: compare it with the source",
                 model->light_count );
}
