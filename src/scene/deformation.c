// Morph targets and skins: in doubles, rounded once.
#include "scene/deformation.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void rf_destroy_deformation( RfDeformation* deformation )
{
    if ( deformation == NULL )
        return;
    for ( int i = 0; deformation->targets != NULL && i < deformation->target_count; ++i )
    {
        RfMorphTarget* target = deformation->targets + i;
        free( target->vertices );
        free( target->positions );
        free( target->normals );
        free( target->tangents );
    }
    free( deformation->targets );
    free( deformation->joints );
    free( deformation->weights );
    free( deformation->flat );
    free( deformation );
}

// Within floats also for absurd weights, whose result is refused later.
static float round_within( double value ) { return (float)fmax( -1e30, fmin( 1e30, value ) ); }

static void add_deltas( const RfMorphTarget* target, const float* deltas, double weight, size_t stride, float* values )
{
    if ( deltas == NULL || values == NULL )
        return;
    for ( size_t k = 0; k < target->count; ++k )
    {
        float* value = values + stride * target->vertices[k];
        for ( size_t c = 0; c < 3; ++c )
            value[c] = round_within( (double)value[c] + weight * (double)deltas[3 * k + c] );
    }
}

void rf_normalise( const double v[3], double scale, float out[3] )
{
    double largest = fmax( fabs( v[0] ), fmax( fabs( v[1] ), fabs( v[2] ) ) );
    out[0] = out[1] = out[2] = 0.0f;
    if ( !( largest > 0.0 && largest <= DBL_MAX ) )
        return;
    double unit[3] = { v[0] / largest, v[1] / largest, v[2] / largest };
    scale /= sqrt( unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2] );
    for ( int c = 0; c < 3; ++c )
        out[c] = (float)( unit[c] * scale );
}

// Normals that were added up are no longer of unit length; those that cancel are 0.
static void normalise_all( float* values, size_t count, size_t stride )
{
    for ( size_t v = 0; values != NULL && v < count; ++v )
    {
        float* at = values + stride * v;
        rf_normalise( ( const double[3] ){ (double)at[0], (double)at[1], (double)at[2] }, 1.0, at );
    }
}

static void morph( const RfDeformation* deformation, const double* weights, RfTriangles* out )
{
    bool normals = false, tangents = false;
    for ( int i = 0; i < deformation->target_count; ++i )
    {
        const RfMorphTarget* target = deformation->targets + i;
        if ( weights[i] == 0.0 )
            continue;
        add_deltas( target, target->positions, weights[i], 3, out->positions );
        add_deltas( target, target->normals, weights[i], 3, out->normals );
        add_deltas( target, target->tangents, weights[i], 4, out->tangents );
        normals = normals || target->normals != NULL;
        tangents = tangents || target->tangents != NULL;
    }
    if ( normals )
        normalise_all( out->normals, out->vertex_count, 3 );
    if ( tangents )
        normalise_all( out->tangents, out->vertex_count, 4 );
}

static void blend( const RfDeformation* deformation, const RfMat4* joints, size_t vertex, RfMat4* out )
{
    const size_t n = (size_t)deformation->influences;
    const uint16_t* joint = deformation->joints + n * vertex;
    const float* weight = deformation->weights + n * vertex;
    memset( out, 0, sizeof *out );
    for ( size_t i = 0; i < n && weight[i] > 0.0f; ++i )
    {
        for ( int k = 0; k < 16; ++k )
            out->m[k] += (double)weight[i] * joints[joint[i]].m[k];
    }
    // floats sum to 1 to their last digit alone, which far from the joint is a way
    for ( int k = 0; k < 16 && out->m[15] > 0.0 && out->m[15] != 1.0; ++k )
        out->m[k] /= out->m[15];
}

static void place_position( const RfMat4* matrix, float* position, double* beyond )
{
    double local[3] = { (double)position[0], (double)position[1], (double)position[2] }, placed[3];
    rf_mat4_apply( matrix, local, 1.0, placed );
    for ( int c = 0; c < 3; ++c )
    {
        // written so that NaN fails
        if ( !( fabs( placed[c] ) <= RF_MAX_COORDINATE ) )
            *beyond = placed[c];
        else
            position[c] = (float)placed[c];
    }
}

// By the inverse transpose: the cofactor matrix, with the sign of the determinant.
static void place_normal( const RfMat4* matrix, double sign, float* normal )
{
    double local[3] = { (double)normal[0], (double)normal[1], (double)normal[2] }, placed[3];
    rf_mat4_apply_cofactor( matrix, local, placed );
    rf_normalise( placed, sign, normal );
}

static void place_tangent( const RfMat4* matrix, double sign, float* tangent )
{
    double local[3] = { (double)tangent[0], (double)tangent[1], (double)tangent[2] }, placed[3];
    rf_mat4_apply( matrix, local, 0.0, placed );
    rf_normalise( placed, 1.0, tangent );
    tangent[3] *= (float)sign;
}

static void place_vertices( const RfDeformation* deformation, const RfDeformer* by, bool* mirrored, RfTriangles* out,
                            double* beyond )
{
    RfMat4 own;
    const RfMat4* matrix = by->matrix;
    for ( size_t v = 0; v < out->vertex_count; ++v )
    {
        if ( by->joints != NULL )
        {
            blend( deformation, by->joints, v, &own );
            matrix = &own;
        }
        mirrored[v] = rf_mat4_det3( matrix ) < 0.0;
        double sign = mirrored[v] ? -1.0 : 1.0;
        place_position( matrix, out->positions + 3 * v, beyond );
        place_normal( matrix, sign, out->normals + 3 * v );
        if ( out->tangents != NULL )
            place_tangent( matrix, sign, out->tangents + 4 * v );
    }
}

static void find_beyond( const RfTriangles* t, double* beyond )
{
    for ( size_t i = 0; i < 3 * (size_t)t->vertex_count; ++i )
    {
        if ( !( fabs( (double)t->positions[i] ) <= RF_MAX_COORDINATE ) )
            *beyond = (double)t->positions[i];
    }
}

bool rf_face_normal( const float* positions, const uint32_t corners[3], double least, float normal[3] )
{
    const float* a = positions + 3 * (size_t)corners[0];
    const float* b = positions + 3 * (size_t)corners[1];
    const float* c = positions + 3 * (size_t)corners[2];
    double u[3], v[3];
    for ( int i = 0; i < 3; ++i )
    {
        u[i] = (double)b[i] - (double)a[i];
        v[i] = (double)c[i] - (double)a[i];
    }
    double n[3] = { u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0] };
    double length = sqrt( n[0] * n[0] + n[1] * n[1] + n[2] * n[2] );
    bool whole = length >= least && length > 0.0;
    for ( int i = 0; i < 3; ++i )
        normal[i] = whole ? (float)( n[i] * ( 1.0 / length ) ) : 0.0f;
    return whole;
}

static bool is_zero( const float* v ) { return v[0] == 0.0f && v[1] == 0.0f && v[2] == 0.0f; }

void rf_grow_bounds( RfVec3* low, RfVec3* high, bool first, RfVec3 at )
{
    RfVec3 l = first ? at : *low, h = first ? at : *high;
    *low = rf_vec3( rf_minf( l.x, at.x ), rf_minf( l.y, at.y ), rf_minf( l.z, at.z ) );
    *high = rf_vec3( rf_maxf( h.x, at.x ), rf_maxf( h.y, at.y ), rf_maxf( h.z, at.z ) );
}

static void finish_triangle( const bool* flat, const float normal[3], const uint32_t* corners, RfMesh* out )
{
    RfTriangles* t = &out->triangles;
    for ( int i = 0; i < 3; ++i )
    {
        float* own = t->normals + 3 * (size_t)corners[i];
        if ( ( flat != NULL && flat[corners[i]] ) || is_zero( own ) )
            memcpy( own, normal, 3 * sizeof *own );
    }
}

// Turns mirrored triangles over, takes out those without area, and gives normals to the vertices that lack one.
static uint32_t finish_triangles( const RfMesh* mesh, const bool* mirrored, double least, RfMesh* out )
{
    RfTriangles* t = &out->triangles;
    const bool* flat = mesh->deformation != NULL ? mesh->deformation->flat : NULL;
    uint32_t whole = 0;
    for ( size_t i = 0; i < t->count; ++i )
    {
        uint32_t* corners = t->indices + 3 * i;
        memcpy( corners, mesh->triangles.indices + 3 * i, 3 * sizeof *corners );
        if ( mirrored != NULL && mirrored[corners[0]] + mirrored[corners[1]] + mirrored[corners[2]] >= 2 )
        {
            uint32_t second = corners[1];
            corners[1] = corners[2];
            corners[2] = second;
        }
        float normal[3];
        if ( !rf_face_normal( t->positions, corners, least, normal ) )
        {
            corners[1] = corners[2] = corners[0];
            continue;
        }
        finish_triangle( flat, normal, corners, out );
        for ( int c = 0; c < 3; ++c )
        {
            const float* p = t->positions + 3 * (size_t)corners[c];
            rf_grow_bounds( &out->bounds_min, &out->bounds_max, whole == 0 && c == 0, rf_vec3( p[0], p[1], p[2] ) );
        }
        whole += 1;
    }
    for ( size_t v = 0; v < t->vertex_count; ++v )
    {
        if ( is_zero( t->normals + 3 * v ) )
            t->normals[3 * v + 2] = 1.0f;
    }
    return whole;
}

// All but what deforms.
static void share( const RfTriangles* from, RfTriangles* out )
{
    RfTriangles own = *out;
    *out = *from;
    out->positions = own.positions;
    out->normals = own.normals;
    out->tangents = from->tangents != NULL ? own.tangents : NULL;
    out->indices = own.indices;
    size_t vertices = from->vertex_count;
    memcpy( out->positions, from->positions, 3 * vertices * sizeof *out->positions );
    memcpy( out->normals, from->normals, 3 * vertices * sizeof *out->normals );
    if ( out->tangents != NULL )
        memcpy( out->tangents, from->tangents, 4 * vertices * sizeof *out->tangents );
}

RfDeformed rf_deform_mesh( const RfMesh* mesh, const RfDeformer* by, bool* mirrored, RfMesh* out )
{
    RfDeformed deformed = { 0 };
    const RfDeformation* deformation = mesh->deformation;
    bool placed = by->joints != NULL || by->matrix != NULL;
    share( &mesh->triangles, &out->triangles );
    out->bounds_min = out->bounds_max = rf_vec3( 0.0f, 0.0f, 0.0f );
    out->deformation = NULL;
    if ( by->weights != NULL && deformation != NULL )
        morph( deformation, by->weights, &out->triangles );
    if ( placed )
        place_vertices( deformation, by, mirrored, &out->triangles, &deformed.beyond );
    else
        find_beyond( &out->triangles, &deformed.beyond );
    if ( !( deformed.beyond == 0.0 ) )
        return deformed;
    deformed.whole = finish_triangles( mesh, placed ? mirrored : NULL, by->least_area, out );
    return deformed;
}
