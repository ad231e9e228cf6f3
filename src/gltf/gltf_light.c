// Punctual lights.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include "base/file.h"
#include "scene/camera.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// KHR_lights_punctual: punctual lights of the nodes of the default scene. Candela and lux are
// taken as W/sr and W/m², as emission is taken as W/(m² sr): a common scale, so that lamps and
// emissive surfaces keep their proportion.

#define EXTENSION "KHR_lights_punctual"
#define HALF_PI 1.57079632679489662
#define MOST_SIZE 1e14 // m

// A light of the document, at the node that has it.
typedef struct Source
{
    RfMovingLamp lamp;   // its values, and what changes them
    int index;           // of the list
    RfProfile** profile; // that of the list's light once it has been read
} Source;

static RfResult read_cone( const RfField* json, Source* source )
{
    double* cone = source->lamp.values.cone;
    cone[0] = 0.0;
    cone[1] = 0.5 * HALF_PI;
    rf_gltf_require( json, "spot", NULL );
    RfField spot = rf_get_object( json, "spot" );
    snprintf( spot.path, sizeof spot.path, "%s", json->path ); // of which messages name the light
    rf_get_number( &spot, "innerConeAngle", rf_any_number(), cone );
    return rf_get_number( &spot, "outerConeAngle", rf_any_number(), cone + 1 );
}

static RfResult check_cone( const RfField* json, const Source* source )
{
    const double* cone = source->lamp.values.cone;
    // exporters round both to the same float: equal angles give a hard edge. Of what changes the pose finds out
    bool changes = source->lamp.changes[RF_CHANGED_INNER_CONE] >= 0 || source->lamp.changes[RF_CHANGED_OUTER_CONE] >= 0;
    if ( !( cone[0] >= 0.0 && ( changes || cone[0] <= cone[1] ) && cone[1] > 0.0 && cone[1] <= HALF_PI + 1e-6 ) )
        return rf_field_fail( json, "cone angles %g and %g must be 0 <= inner <= outer, and outer above 0, at most pi/2", cone[0],
                              cone[1] );
    return RF_OK;
}

static RfResult read_kind( const RfGltf* gltf, const RfField* json, RfPunctual* out )
{
    const char *type = "", *where = json->path;
    rf_gltf_require( json, "type", NULL );
    RF_TRY( rf_get_text( json, "type", &type ) );
    out->cos_inner = 1.0f;
    out->cos_outer = -1.0f;
    if ( strcmp( type, "point" ) == 0 )
        out->kind = RF_PUNCTUAL_POINT;
    else if ( strcmp( type, "directional" ) == 0 )
        out->kind = RF_PUNCTUAL_DIRECTIONAL;
    else if ( strcmp( type, "spot" ) == 0 )
        out->kind = RF_PUNCTUAL_SPOT;
    else
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "type '%.20s' must be point, spot or directional", type );
    return RF_OK;
}

// As bright, as wide and as far as it ever is.
static void set_light( const RfLampValues* most, RfPunctual* out )
{
    if ( out->kind == RF_PUNCTUAL_SPOT )
        rf_set_cone( out, fmin( most->cone[0], most->cone[1] ), most->cone[1] );
    out->intensity = rf_vec3_of( most->color, most->intensity );
    out->range = (float)most->range;
}

// Intensity profiles: what `extras.reframe` of a light says,
//
//     {"ies": "file.ies"} or {"ies": {"bufferView": 7}}
//     {"profile": {"vertical": [0, 90], "horizontal": [0], "relative": [1, 0]}}
//
// by which its intensity is multiplied. A table takes the place of a spot's cone.

// By a scene file, the file lies beside it.
static RfResult read_file( RfGltf* gltf, const RfField* field, bool beside, RfProfile** out )
{
    const char* name = NULL;
    char* path = NULL;
    uint8_t* bytes = NULL;
    size_t size = 0;
    RfError error = { 0 };
    RF_TRY( rf_field_text( field, &name ) );
    if ( beside )
        path = rf_path_beside( field->file, name );
    if ( beside && path == NULL )
        return rf_gltf_no_memory( gltf, "profiles" );
    if ( !beside )
        RF_TRY( rf_gltf_resolve_uri( gltf, field->path, name, &path ) );
    RfResult result = rf_read_file( path, RF_PROFILE_BYTES, &bytes, &size, &error );
    if ( result == RF_OK )
        result = rf_read_ies( path, bytes, size, out, &error );
    if ( result == RF_OK )
        gltf->scene->content_hash = rf_hash_bytes( gltf->scene->content_hash, bytes, size );
    free( path );
    free( bytes );
    return result == RF_OK ? RF_OK : rf_field_fail_as( field, result, &error );
}

// The bytes of the view are in the scene's hash already.
static RfResult read_view( RfGltf* gltf, const RfField* field, RfProfile** out )
{
    static const char* const s_keys[] = { "bufferView", NULL };
    const uint8_t* bytes = NULL;
    int number = 0;
    size_t length = 0;
    RfError error = { 0 };
    rf_field_keys( field, s_keys );
    rf_field_require( field, "bufferView", "the number of a buffer view" );
    RfField view = rf_field_member( field, "bufferView" );
    RF_TRY( rf_field_whole( &view, 0.0, (double)gltf->counts[RF_GLTF_BUFFER_VIEWS] - 1.0, &number ) );
    RF_TRY( rf_gltf_whole_view( gltf, view.path, number, RF_PROFILE_BYTES, &bytes, &length ) );
    RfResult result = rf_read_ies( rf_where( "bufferViews[%d]", number ).text, bytes, length, out, &error );
    return result == RF_OK ? RF_OK : rf_field_fail_as( field, result, &error );
}

static RfResult read_numbers( const RfField* table, const char* key, const char* item, int least, int most, double** values,
                              int* count )
{
    RfField array = rf_field_member( table, key );
    rf_field_require( table, key, "an array of numbers" );
    RF_TRY( rf_field_array( &array, item, (size_t)least, (size_t)most ) );
    *count = (int)json_array_size( array.json );
    *values = malloc( (size_t)*count * sizeof **values );
    if ( *values == NULL )
        return rf_field_no_memory( &array );
    return rf_field_numbers( &array, rf_range( 0.0, 1e12 ), *count, *values );
}

static RfResult read_table( const RfField* field, RfProfile** out )
{
    static const char* const s_keys[] = { "vertical", "horizontal", "relative", NULL };
    RfProfileTable table = { 0 };
    int count = 0;
    RfError error = { 0 };
    rf_field_keys( field, s_keys );
    read_numbers( field, "vertical", "degrees", 2, RF_PROFILE_ANGLES, &table.vertical, &table.rows );
    read_numbers( field, "horizontal", "degrees", 1, RF_PROFILE_ANGLES, &table.horizontal, &table.columns );
    RfResult result = read_numbers( field, "relative", "intensities", 2, RF_PROFILE_VALUES, &table.value, &count );
    if ( result == RF_OK && count != table.rows * table.columns )
        result = rf_field_fail( field, "has %d intensities for %d vertical and %d horizontal angles: must be %d", count,
                                table.rows, table.columns, table.rows * table.columns );
    else if ( result == RF_OK )
    {
        result = rf_make_profile( "the table", &table, out, &error );
        result = result == RF_OK ? RF_OK : rf_field_fail_as( field, result, &error );
    }
    free( table.vertical );
    free( table.horizontal );
    free( table.value );
    return result;
}

static RfResult read_any( RfGltf* gltf, const RfField* ours, const RfField* edit, RfProfile** out )
{
    RfField given = rf_field_member( edit, "ies" );
    RfField ies = rf_field_member( ours, "ies" ), table = rf_field_member( ours, "profile" );
    if ( given.json != NULL )
        return read_file( gltf, &given, true, out );
    if ( ies.json != NULL && table.json != NULL )
        return rf_field_fail( ours, "has both ies and profile: leave one out" );
    if ( table.json != NULL )
        return read_table( &table, out );
    if ( ies.json == NULL )
        return RF_OK;
    return json_is_object( ies.json ) ? read_view( gltf, &ies, out ) : read_file( gltf, &ies, false, out );
}

// A file may name the same table in each of many lights.
#define MOST_VALUES ( (size_t)1 << 24 )

static RfResult load_profile( RfGltf* gltf, const RfField* ours, const RfField* edit, RfProfile** out )
{
    RfResult result = read_any( gltf, ours, edit, out );
    if ( result != RF_OK || *out == NULL )
        return result;
    gltf->profile_values += (size_t)( *out )->rows * (size_t)( *out )->columns;
    return gltf->profile_values <= MOST_VALUES
               ? RF_OK
               : rf_field_fail( ours, "the profiles of the file's lights have more than %zu values", MOST_VALUES );
}

// What says more of a light than glTF: its `extras.reframe`, then a scene file.
typedef struct Extras
{
    RfField sources[2]; // messages of both name the first
    RfField edit;       // the second, as the scene file has it
} Extras;

static Extras open_extras( const RfGltf* gltf, const RfField* json, int index )
{
    Extras out = { .sources = { rf_gltf_extras( json ) }, .edit = rf_make_field( "", "", NULL, gltf->error ) };
    if ( gltf->light_edits != NULL )
        out.edit = gltf->light_edits[index];
    out.edit.error = gltf->error;
    RfWhere where = rf_where( "%.140s.extras.reframe", json->path );
    out.sources[1] = rf_make_field( gltf->path, where.text, out.edit.json, gltf->error );
    return out;
}

static bool has( const Extras* e, const char* key ) { return rf_has_member( e->sources, key ) || rf_has_member( &e->edit, key ); }

static RfResult read_profile( RfGltf* gltf, const Extras* e, Source* source, RfPunctual* out )
{
    RfResult result = *source->profile == NULL ? load_profile( gltf, e->sources, &e->edit, source->profile ) : RF_OK;
    if ( result != RF_OK || *source->profile == NULL )
        return result;
    out->profile = *source->profile;
    out->profile->references += 1;
    out->turned = true;
    if ( !rf_has_member( e->sources, "profile" ) || rf_has_member( &e->edit, "ies" ) || out->kind != RF_PUNCTUAL_SPOT )
        return RF_OK;
    if ( source->lamp.changes[RF_CHANGED_INNER_CONE] >= 0 || source->lamp.changes[RF_CHANGED_OUTER_CONE] >= 0 )
        return rf_field_fail( e->sources,
                              "has a profile, which stands still, in the place of a cone that changes: leave it out" );
    out->kind = RF_PUNCTUAL_POINT;
    return RF_OK;
}

static void read_radius( const RfField* ours, RfPunctual* out )
{
    double radius = (double)out->radius;
    rf_get_number( ours, "radius", rf_range( 0.0, MOST_SIZE ), &radius );
    out->radius = (float)radius;
    rf_get_bool( ours, "soft", &out->soft );
}

static RfResult read_angle( const Extras* e, RfPunctual* out )
{
    double angle = 0.0;
    for ( int i = 0; i < 2; ++i )
        rf_get_number( e->sources + i, "angle", rf_range( 0.0, 180.0 ), &angle );
    double sine = sin( angle * ( HALF_PI / 360.0 ) );
    out->versine = (float)( 2.0 * sine * sine );
    return rf_json_result( e->sources );
}

static RfResult read_plane( const Extras* e, RfPunctual* out )
{
    static const char* const s_shapes[] = { "rectangle", "ellipse", NULL };
    int shape = 0;
    double size[2] = { 0.0, 0.0 }, spread = 180.0;
    if ( !has( e, "size" ) )
        rf_field_require( e->sources + ( e->sources[0].json == NULL ), "size", "[width, height], m" );
    for ( int i = 0; i < 2; ++i )
    {
        rf_get_choice( e->sources + i, "shape", s_shapes, &shape );
        rf_get_numbers( e->sources + i, "size", rf_above( 0.0, MOST_SIZE ), 2, size );
        rf_get_number( e->sources + i, "spread", rf_range( 1.0, 180.0 ), &spread );
    }
    if ( rf_json_result( e->sources ) != RF_OK )
        return rf_json_result( e->sources );
    double half = spread * ( HALF_PI / 180.0 );
    out->kind = RF_PUNCTUAL_PLANE;
    out->turned = true;
    out->ellipse = shape == 1;
    out->half[0] = (float)( 0.5 * size[0] );
    out->half[1] = (float)( 0.5 * size[1] );
    if ( spread < 180.0 )
    {
        out->tan_spread = (float)tan( half );
        out->spread_scale = (float)( 1.0 / ( tan( half ) - half ) ); // the integral over the hemisphere is π
    }
    return RF_OK;
}

// `extras.reframe` of a light. Sizes are in metres and degrees; a point with a shape becomes a plane.
//
//     {"radius": 0.1, "soft": true, "ies": "lamp.ies"}              a point or a spot
//     {"angle": 0.5}                                                a directional light
//     {"shape": "rectangle", "size": [1, 0.5], "spread": 120}       a point
//     {"light_group": "key"}                                        any of them
static RfResult read_extras( RfGltf* gltf, const RfField* json, Source* source, RfPunctual* out )
{
    static const char* const s_lamp[] = { "ies", "light_group", "profile", "radius", "soft", NULL };
    static const char* const s_sun[] = { "angle", "light_group", NULL };
    static const char* const s_plane[] = { "light_group", "shape", "size", "spread", NULL };
    Extras e = open_extras( gltf, json, source->index );
    bool is_plane = out->kind == RF_PUNCTUAL_POINT && has( &e, "shape" ), is_sun = out->kind == RF_PUNCTUAL_DIRECTIONAL;
    for ( int i = 0; i < 2; ++i )
    {
        if ( e.sources[i].json != NULL )
            rf_field_keys( e.sources + i, is_sun ? s_sun : is_plane ? s_plane : s_lamp );
    }
    if ( rf_json_result( json ) != RF_OK || is_sun || is_plane )
        return rf_json_result( json ) != RF_OK ? rf_json_result( json ) : is_sun ? read_angle( &e, out ) : read_plane( &e, out );
    read_radius( e.sources, out );
    read_radius( e.sources + 1, out );
    return rf_json_result( json ) == RF_OK ? read_profile( gltf, &e, source, out ) : rf_json_result( json );
}

static RfResult read_light( RfGltf* gltf, const RfField* json, Source* source, RfPunctual* out )
{
    RfLampValues* values = &source->lamp.values;
    *values = ( RfLampValues ){ .intensity = 1.0, .color = { 1.0, 1.0, 1.0 }, .range = (double)INFINITY };
    RfResult result = read_kind( gltf, json, out );
    bool spot = out->kind == RF_PUNCTUAL_SPOT;
    if ( result == RF_OK && spot )
        read_cone( json, source );
    rf_gltf_read_value( gltf, json, RF_CHANGED_COLOR, values );
    rf_gltf_read_value( gltf, json, RF_CHANGED_INTENSITY, values );
    RF_TRY( rf_gltf_read_value( gltf, json, RF_CHANGED_RANGE, values ) );
    RfLampValues most = *values;
    rf_gltf_find_changes( gltf, RF_OF_LAMP, source->index, values, &most, source->lamp.changes );
    if ( spot )
        check_cone( json, source );
    else
        source->lamp.changes[RF_CHANGED_INNER_CONE] = source->lamp.changes[RF_CHANGED_OUTER_CONE] = -1;
    RF_TRY( read_extras( gltf, json, source, out ) );
    set_light( &most, out );
    // higher ones would overflow close to the light
    double factor = out->profile != NULL ? fmax( (double)out->profile->most, 1.0 ) : 1.0;
    return rf_gltf_check_limit( gltf, json->path, "intensity", values->intensity * factor,
                                rf_changed_traits( RF_CHANGED_INTENSITY )->high );
}

// That of its node overrules its own.
static RfResult read_group( const RfGltf* gltf, const RfField* json, int node, int index, RfPunctual* out )
{
    Extras e = open_extras( gltf, json, index );
    int own, tag = gltf->nodes[node].light_group;
    RfResult result = rf_gltf_read_tag( gltf, rf_has_member( &e.edit, "light_group" ) ? &e.edit : e.sources, &own );
    out->light_group = (uint16_t)( tag >= 0 ? tag : own >= 0 ? own : 0 );
    return result;
}

// At the origin of the node, pointing along −z; scale is ignored.
static RfResult place_light( const RfGltf* gltf, int node, const char* where, RfPunctual* out )
{
    RfMat4 world;
    rf_node_world_matrix( gltf->scene, node, rf_gltf_rest_time( gltf, node ), &world );
    const double* m = world.m;
    bool finite =
        isfinite( m[8] ) && isfinite( m[9] ) && isfinite( m[10] ) && isfinite( m[12] ) && isfinite( m[13] ) && isfinite( m[14] );
    if ( !finite || ( !rf_turn_lamp( m, out ) && ( out->kind != RF_PUNCTUAL_POINT || out->turned ) ) )
        return rf_gltf_fail( gltf, RF_ERROR_FORMAT, where, "its light has no direction: the node's transform is not invertible" );
    const double* origin = gltf->scene->origin;
    out->position = rf_vec3( (float)( m[12] - origin[0] ), (float)( m[13] - origin[1] ), (float)( m[14] - origin[2] ) );
    return RF_OK;
}

// What moves, is switched or changes.
static RfResult note_change( RfGltf* gltf, int node, Source* source, RfPunctual* out )
{
    RfMovingLamp* lamp = &source->lamp;
    bool moves = rf_gltf_changes( gltf, node );
    if ( gltf->freeze )
        return moves || rf_gltf_light_changes( gltf, source->index ) ? rf_gltf_note_frozen( gltf, "light", out->name ) : RF_OK;
    for ( int v = 0; v < RF_CHANGED_LAMP_VALUES; ++v )
        out->changes = out->changes || lamp->changes[v] >= 0;
    out->changes = out->changes || moves;
    lamp->node = moves ? node : -1;
    lamp->punctual = (int)( out - gltf->scene->punctuals );
    return out->changes ? rf_gltf_add_lamp( gltf, lamp ) : RF_OK;
}

// `profiles`: of the list's lights.
static RfResult load_node_light( RfGltf* gltf, const RfField* lights, int node, const RfField* extension, RfProfile** profiles )
{
    int64_t index = -1, count = (int64_t)json_array_size( lights->json );
    if ( count == 0 )
        return rf_field_fail( extension, "the document's " EXTENSION " has no lights" );
    rf_gltf_require( extension, "light", NULL );
    RF_TRY( rf_get_integer( extension, "light", 0, count - 1, &index ) );
    RfField json = rf_field_item( lights, (size_t)index );
    if ( !json_is_object( json.json ) )
        return rf_field_fail( &json, "must be an object" );
    RfPunctual* out = gltf->scene->punctuals + gltf->scene->punctual_count;
    Source source = { .lamp = { .changes = { -1, -1, -1, -1, -1 } }, .index = (int)index, .profile = profiles + index };
    gltf->scene->punctual_count += 1;
    RF_TRY( read_light( gltf, &json, &source, out ) );
    RF_TRY( read_group( gltf, &json, node, (int)index, out ) );
    if ( ( gltf->freeze || !rf_gltf_varies( gltf, node ) ) )
        RF_TRY( place_light( gltf, node, extension->path, out ) );
    RF_TRY( rf_gltf_copy_name( &json, gltf->scene->nodes[node].name, &out->name ) );
    return note_change( gltf, node, &source, out );
}

static RfResult load_lights( RfGltf* gltf, const RfField* lights, RfProfile** profiles )
{
    RfResult result = RF_OK;
    RF_TRY(
        rf_gltf_allocate( gltf, "lights", &gltf->scene->punctuals, (size_t)gltf->order_count, sizeof *gltf->scene->punctuals ) );
    for ( int i = 0; result == RF_OK && i < gltf->order_count; ++i )
    {
        int node = gltf->order[i];
        RfField json = rf_gltf_item_field( gltf, RF_GLTF_NODES, node ), extension = rf_gltf_extension( &json, EXTENSION );
        if ( extension.json == NULL )
        {
            result = rf_json_result( &json );
            continue;
        }
        bool hidden = rf_gltf_visibility( gltf, node ) == RF_GLTF_HIDDEN;
        if ( hidden && rf_gltf_changes( gltf, node ) )
            result = rf_gltf_note_frozen( gltf, "light", gltf->scene->nodes[node].name );
        if ( !hidden )
            result = load_node_light( gltf, lights, node, &extension, profiles );
    }
    return result;
}

RfResult rf_gltf_load_lights( RfGltf* gltf )
{
    RfField root = rf_gltf_root( gltf );
    RfField json = rf_gltf_field( gltf, "extensions." EXTENSION, rf_gltf_extension( &root, EXTENSION ).json );
    RfField lights = rf_get_array( &json, "lights" );
    RF_TRY( rf_json_result( &root ) );
    size_t count = json_array_size( lights.json );
    RfProfile** profiles;
    RF_TRY( rf_gltf_allocate( gltf, "lights", &profiles, count, sizeof *profiles ) );
    RfResult result = load_lights( gltf, &lights, profiles );
    for ( size_t i = 0; i < count; ++i )
        rf_release_profile( profiles[i] );
    free( profiles );
    return result;
}
