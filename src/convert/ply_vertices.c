// Vertices of PLY: positions, normals, texture coordinates, colours.
#include "convert/ply_reader.h"
#include "image/decode.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_VERTICES ( 1u << 30 )

// The destination of a vertex property.
typedef struct Slot
{
    float* values;
    int stride, at;
    float scale;
    bool colour, srgb;
} Slot;

static float colour_scale( RfPlyType type )
{
    switch ( type )
    {
        case RF_PLY_UINT8: return 1.0f / 255.0f;
        case RF_PLY_UINT16: return 1.0f / 65535.0f;
        default: return 1.0f;
    }
}

static int find( const RfPlyElement* element, const char* const* names )
{
    for ( ; *names != NULL; ++names )
    {
        for ( int i = 0; i < element->property_count; ++i )
        {
            if ( strcmp( element->properties[i].name, *names ) == 0 && !element->properties[i].is_list )
                return i;
        }
    }
    return -1;
}

// Allocates an array for a group of properties if all of them exist, else NULL.
static RfResult bind( RfPlyReader* r, const RfPlyElement* element, const char* const names[][4], int count, int stride,
                      bool colour, float** values, Slot* slots )
{
    int properties[4];
    for ( int k = 0; k < count; ++k )
    {
        properties[k] = find( element, names[k] );
        if ( properties[k] < 0 )
            return RF_OK;
    }
    *values = malloc( (size_t)element->count * (size_t)stride * sizeof( float ) );
    if ( *values == NULL )
        return rf_ply_no_memory( r );
    for ( int k = 0; k < count; ++k )
    {
        RfPlyType type = element->properties[properties[k]].type;
        if ( colour && type != RF_PLY_UINT8 && type != RF_PLY_UINT16 && type < RF_PLY_FLOAT32 )
            return rf_ply_fail( &r->file, "property %s wants uchar, ushort or float: the white value of other types is undefined",
                                names[k][0] );
        slots[properties[k]] = ( Slot ){ *values, stride,
                                         k,       colour ? colour_scale( type ) : 1.0f,
                                         colour,  colour && type < RF_PLY_FLOAT32 && k < 3 };
    }
    return RF_OK;
}

static RfResult bind_vertices( RfPlyReader* r, const RfPlyElement* element, Slot* slots )
{
    static const char* const s_places[][4] = { { "x" }, { "y" }, { "z" } };
    static const char* const s_normals[][4] = { { "nx" }, { "ny" }, { "nz" } };
    static const char* const s_uvs[][4] = { { "s", "u", "texture_u" }, { "t", "v", "texture_v" } };
    static const char* const s_colors[][4] = { { "red" }, { "green" }, { "blue" }, { "alpha" } };
    static const char* const s_alpha[] = { "alpha", NULL };
    RfModelMesh* m = r->mesh;
    RfResult result = bind( r, element, s_places, 3, 3, false, &m->positions, slots );
    if ( result == RF_OK && m->positions == NULL )
        return rf_ply_fail( &r->file, "element vertex has no x, y and z" );
    if ( result == RF_OK )
        result = bind( r, element, s_normals, 3, 3, false, &m->normals, slots );
    if ( result == RF_OK )
        result = bind( r, element, s_uvs, 2, 2, false, &m->uvs, slots );
    int channels = find( element, s_alpha ) >= 0 ? 4 : 3;
    if ( result == RF_OK )
        result = bind( r, element, s_colors, channels, 4, true, &m->colors, slots );
    for ( uint64_t i = 0; m->colors != NULL && i < element->count; ++i )
        m->colors[4 * i + 3] = 1.0f;
    return result;
}

static RfResult store( RfPlyReader* r, const RfPlyProperty* property, const Slot* slot, uint64_t i )
{
    double value;
    RfResult result = rf_ply_read_value( &r->file, property->type, &value );
    if ( result != RF_OK )
        return result;
    if ( !( fabs( value ) <= 3e38 ) )
        return rf_ply_fail( &r->file, "%s of vertex %llu is not a finite number", property->name, (unsigned long long)i );
    float f = (float)value * slot->scale;
    if ( slot->colour && !( f >= 0.0f && f <= 1.0f ) ) // glTF colours are limited to 0 to 1
    {
        f = f > 1.0f ? 1.0f : 0.0f;
        r->clamped += 1;
    }
    slot->values[(size_t)i * (size_t)slot->stride + (size_t)slot->at] = slot->srgb ? rf_srgb_to_linear( f ) : f;
    return RF_OK;
}

RfResult rf_ply_read_vertices( RfPlyReader* r, const RfPlyElement* element )
{
    Slot slots[RF_PLY_MAX_PROPERTIES] = { { 0 } };
    if ( r->has_vertices )
        return rf_ply_fail( &r->file, "has two elements named vertex" );
    r->has_vertices = true;
    if ( element->count > MAX_VERTICES )
        return rf_fail( r->file.error, RF_ERROR_UNSUPPORTED, "%s: has more than %u vertices: split it", r->file.path,
                        MAX_VERTICES );
    if ( element->count == 0 )
        return RF_OK;
    RfResult result = bind_vertices( r, element, slots );
    r->mesh->vertex_count = (uint32_t)element->count;
    for ( uint64_t i = 0; result == RF_OK && i < element->count; ++i )
    {
        for ( int k = 0; result == RF_OK && k < element->property_count; ++k )
            result = slots[k].values != NULL ? store( r, element->properties + k, slots + k, i )
                                             : rf_ply_skip( &r->file, element->properties + k );
    }
    return result;
}

// Normalises the normals, or drops them all so that the mesh is flat-shaded; flips v.
void rf_ply_finish_vertices( RfPlyReader* r )
{
    RfModelMesh* m = r->mesh;
    bool whole = m->normals != NULL;
    for ( uint32_t i = 0; whole && i < m->vertex_count; ++i )
    {
        float* n = m->normals + 3 * (size_t)i;
        double length = sqrt( (double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] + (double)n[2] * (double)n[2] );
        whole = length > 1e-12 && isfinite( length );
        for ( int c = 0; whole && c < 3; ++c )
            n[c] = (float)( (double)n[c] / length );
    }
    if ( m->normals != NULL && !whole )
    {
        rf_warn( r->log, "%s: a normal has length 0: all normals are left out", r->file.path );
        free( m->normals );
        m->normals = NULL;
    }
    for ( uint32_t i = 0; m->uvs != NULL && i < m->vertex_count; ++i )
        m->uvs[2 * (size_t)i + 1] = 1.0f - m->uvs[2 * (size_t)i + 1];
    if ( r->dropped > 0 )
        rf_warn( r->log, "%s: %llu faces of less than three corners are left out", r->file.path, (unsigned long long)r->dropped );
    if ( r->clamped > 0 )
        rf_warn( r->log, "%s: %llu colour values are not between 0 and 1: they are clamped", r->file.path,
                 (unsigned long long)r->clamped );
    if ( r->crossed > 0 )
        rf_warn( r->log, "%s: %llu faces intersect themselves: their triangulation may be wrong", r->file.path,
                 (unsigned long long)r->crossed );
}
