// Triangulates the faces and strips of PLY.
#include "convert/ply_reader.h"
#include "convert/polygon.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_TRIANGLES ( 1u << 28 )
#define MAX_CORNERS 65536 // per polygon
#define CUT_STEPS_PER_CORNER 64

static bool reserve_corners( RfPlyReader* r, uint32_t count )
{
    if ( count <= r->corner_room )
        return true;
    free( r->corners );
    free( r->cut );
    r->corner_room = 2 * count;
    r->corners = malloc( (size_t)r->corner_room * sizeof *r->corners );
    r->cut = malloc( 3 * (size_t)r->corner_room * sizeof *r->cut );
    return r->corners != NULL && r->cut != NULL;
}

static RfResult append( RfPlyReader* r, uint32_t triangles )
{
    RfModelMesh* m = r->mesh;
    if ( triangles > MAX_TRIANGLES - m->triangle_count )
        return rf_fail( r->file.error, RF_ERROR_UNSUPPORTED, "%s: has more than %u triangles: split it", r->file.path,
                        MAX_TRIANGLES );
    if ( m->triangle_count + (size_t)triangles > r->triangle_room )
    {
        size_t room = 2 * r->triangle_room + triangles + 256;
        uint32_t* grown = realloc( m->indices, room * 3 * sizeof *grown );
        if ( grown == NULL )
            return rf_ply_no_memory( r );
        m->indices = grown;
        r->triangle_room = room;
    }
    memcpy( m->indices + 3 * (size_t)m->triangle_count, r->cut, (size_t)triangles * 3 * sizeof *r->cut );
    m->triangle_count += triangles;
    return RF_OK;
}

static bool is_vertex( const RfPlyReader* r, double value )
{
    return value >= 0.0 && value < (double)r->mesh->vertex_count && value == floor( value );
}

static RfResult read_polygon( RfPlyReader* r, const RfPlyProperty* property, uint64_t face )
{
    uint32_t count = 0;
    RfResult result = rf_ply_read_count( &r->file, property, &count );
    if ( result == RF_OK && count > MAX_CORNERS )
        return rf_ply_fail( &r->file, "face %llu has %u corners, more than %u", (unsigned long long)face, count, MAX_CORNERS );
    if ( result == RF_OK && !reserve_corners( r, count ) )
        return rf_ply_no_memory( r );
    for ( uint32_t i = 0; result == RF_OK && i < count; ++i )
    {
        double value = 0.0;
        result = rf_ply_read_value( &r->file, property->type, &value );
        if ( result == RF_OK && !is_vertex( r, value ) )
            return rf_ply_fail( &r->file, "corner %u of face %llu is vertex %.9g of %u", i, (unsigned long long)face, value,
                                r->mesh->vertex_count );
        r->corners[i] = (uint32_t)value;
    }
    if ( result != RF_OK )
        return result;
    if ( count < 3 )
    {
        r->dropped += 1;
        return RF_OK;
    }
    r->cut_steps += (uint64_t)count * CUT_STEPS_PER_CORNER;
    RfCut cut = rf_cut_polygon( r->mesh->positions, r->corners, count, r->cut, &r->cut_steps );
    if ( cut == RF_CUT_GIVEN_UP )
        return rf_fail( r->file.error, RF_ERROR_UNSUPPORTED,
                        "%s: face %llu of %u corners takes too long to triangulate: triangulate it first", r->file.path,
                        (unsigned long long)face, count );
    r->crossed += cut == RF_CUT_CROSSED;
    return append( r, count - 2 );
}

// Finds the list of vertex indices of an element.
static RfResult find_corners( const RfPlyReader* r, const RfPlyElement* element, int* list )
{
    *list = -1;
    for ( int k = 0; k < element->property_count && *list < 0; ++k )
    {
        const RfPlyProperty* p = element->properties + k;
        if ( p->is_list && ( strcmp( p->name, "vertex_indices" ) == 0 || strcmp( p->name, "vertex_index" ) == 0 ) )
            *list = k;
    }
    if ( element->count > 0 && *list < 0 )
        return rf_ply_fail( &r->file, "element %s has no list vertex_indices", element->name );
    if ( element->count > 0 && !r->has_vertices )
        return rf_ply_fail( &r->file, "its %s come before its vertices",
                            strcmp( element->name, "face" ) == 0 ? "faces" : element->name );
    return RF_OK;
}

RfResult rf_ply_read_faces( RfPlyReader* r, const RfPlyElement* element )
{
    int list = -1;
    RfResult result = find_corners( r, element, &list );
    for ( uint64_t i = 0; result == RF_OK && i < element->count; ++i )
    {
        for ( int k = 0; result == RF_OK && k < element->property_count; ++k )
            result = k == list ? read_polygon( r, element->properties + k, i ) : rf_ply_skip( &r->file, element->properties + k );
    }
    return result;
}

// Adds a corner to a strip: `at` corners came before it since the last -1, the last two of
// which are in r->corners.
static RfResult add_corner( RfPlyReader* r, uint32_t corner, uint32_t at )
{
    uint32_t a = r->corners[0], b = r->corners[1];
    r->corners[0] = at > 0 ? b : corner;
    r->corners[1] = corner;
    if ( at < 2 || a == b || b == corner || a == corner ) // strips contain degenerate triangles to change direction
        return RF_OK;
    r->cut[0] = at % 2 == 0 ? a : b;
    r->cut[1] = at % 2 == 0 ? b : a;
    r->cut[2] = corner;
    return append( r, 1 );
}

static RfResult read_strips( RfPlyReader* r, const RfPlyProperty* property, uint64_t element )
{
    uint32_t count = 0, at = 0;
    RfResult result = rf_ply_read_count( &r->file, property, &count );
    for ( uint32_t i = 0; result == RF_OK && i < count; ++i )
    {
        double value = 0.0;
        result = rf_ply_read_value( &r->file, property->type, &value );
        bool ends = value == -1.0;
        if ( result == RF_OK && !ends && !is_vertex( r, value ) )
            return rf_ply_fail( &r->file, "corner %u of tristrips %llu is vertex %.9g of %u, and not -1", i,
                                (unsigned long long)element, value, r->mesh->vertex_count );
        if ( result == RF_OK && !ends )
            result = add_corner( r, (uint32_t)value, at );
        r->dropped += ends && at > 0 && at < 3;
        at = ends ? 0 : at + 1;
    }
    r->dropped += at > 0 && at < 3;
    return result;
}

RfResult rf_ply_read_strips( RfPlyReader* r, const RfPlyElement* element )
{
    int list = -1;
    RfResult result = find_corners( r, element, &list );
    if ( result == RF_OK && !reserve_corners( r, 3 ) )
        return rf_ply_no_memory( r );
    for ( uint64_t i = 0; result == RF_OK && i < element->count; ++i )
    {
        for ( int k = 0; result == RF_OK && k < element->property_count; ++k )
            result = k == list ? read_strips( r, element->properties + k, i ) : rf_ply_skip( &r->file, element->properties + k );
    }
    return result;
}
