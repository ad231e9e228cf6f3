// Specks in the JSON of a render, their sum over its frames, and the sentence about them.
#include "cli/render/specks_json.h"

#include "cli/messages.h"
#include "render/estimator.h"
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define MOSTLY 0.5 // of the specks' error

static json_t* part_json( int64_t pixels, double share )
{
    return json_pack( "{s:I, s:o}", "pixels", (json_int_t)pixels, "share", rf_json_number( share ) );
}

static json_t* head_json( int64_t pixels, double share, double rest )
{
    return RF_SET_FIGURES( part_json( pixels, share ), { "rest_relmse", rest },
                           { "rest_noise_percent", rf_noise_percent( rest ) } );
}

// Adds pixels to an object that part_json made.
static void add_to_part( json_t* part, double pixels, double share )
{
    json_object_set_new( part, "pixels", json_integer( (json_int_t)( rf_json_number_of( part, "pixels" ) + pixels ) ) );
    json_object_set_new( part, "share", rf_json_number( rf_json_number_of( part, "share" ) + share ) );
}

static json_t* no_kinds( void )
{
    json_t* kinds = json_object();
    for ( int k = 0; k < RF_SPECK_KINDS; ++k )
        json_object_set_new( kinds, rf_speck_kind_name( (RfSpeckKind)k ), part_json( 0, 0.0 ) );
    return kinds;
}

json_t* rf_specks_json( const RfSpecks* specks, const RfScene* scene )
{
    json_t *json = head_json( specks->pixels, specks->share, specks->rest ), *kinds = no_kinds(), *materials = json_array();
    for ( int p = 0; p < specks->part_count; ++p )
    {
        const RfSpeckPart* part = specks->parts + p;
        json_t* row = part_json( part->pixels, part->share );
        json_object_set_new( row, "kind", json_string( rf_speck_kind_name( part->kind ) ) );
        json_object_set_new( row, "material",
                             part->material >= 0 ? rf_json_text( scene->materials[part->material].name ) : json_null() );
        json_array_append_new( materials, row );
        add_to_part( json_object_get( kinds, rf_speck_kind_name( part->kind ) ), part->pixels, part->share );
    }
    json_object_set_new( json, "kinds", kinds );
    json_object_set_new( json, "materials", materials );
    return json;
}

static double at_least_0( double value ) { return isgreater( value, 0.0 ) ? value : 0.0; }

// The row of the same material and kind, made where there is none.
static json_t* find_row( json_t* materials, const json_t* like )
{
    size_t i;
    json_t* row;
    json_array_foreach( materials, i, row )
    {
        if ( json_equal( json_object_get( row, "kind" ), json_object_get( like, "kind" ) ) &&
             json_equal( json_object_get( row, "material" ), json_object_get( like, "material" ) ) )
            return row;
    }
    row = part_json( 0, 0.0 );
    json_object_set( row, "kind", json_object_get( like, "kind" ) );
    json_object_set( row, "material", json_object_get( like, "material" ) );
    json_array_append_new( materials, row );
    return row;
}

// Adds the rows of a frame with so much of the error of all.
static void add_materials( const json_t* specks, double weight, json_t* kinds, json_t* materials )
{
    size_t i;
    json_t* row;
    json_array_foreach( json_object_get( specks, "materials" ), i, row )
    {
        const char* kind = json_string_value( json_object_get( row, "kind" ) );
        json_t* of_kind = kind != NULL ? json_object_get( kinds, kind ) : NULL;
        double pixels = at_least_0( rf_json_number_of( row, "pixels" ) );
        double share = weight * at_least_0( rf_json_number_of( row, "share" ) );
        if ( of_kind == NULL )
            continue;
        add_to_part( of_kind, pixels, share );
        add_to_part( find_row( materials, row ), pixels, share );
    }
}

static json_t* specks_of( const json_t* frame )
{
    json_t* specks = json_object_get( frame, "specks" );
    bool known = isgreaterequal( rf_json_number_of( frame, "relmse_likely" ), 0.0 ) &&
                 isgreaterequal( rf_json_number_of( specks, "rest_relmse" ), 0.0 );
    return known ? specks : NULL;
}

static void sort_rows( json_t* rows )
{
    for ( size_t i = 1; i < json_array_size( rows ); ++i )
    {
        for ( size_t k = i; k > 0; --k )
        {
            json_t *above = json_array_get( rows, k - 1 ), *row = json_array_get( rows, k );
            if ( rf_json_number_of( above, "share" ) >= rf_json_number_of( row, "share" ) )
                break;
            json_incref( above );
            json_array_set( rows, k - 1, row );
            json_array_set_new( rows, k, above );
        }
    }
}

json_t* rf_sum_specks( const json_t* frames )
{
    double likely = 0.0, rest = 0.0, share = 0.0, pixels = 0.0;
    int count = 0;
    size_t i;
    json_t* frame;
    json_array_foreach( frames, i, frame )
    {
        count += specks_of( frame ) != NULL;
        likely += specks_of( frame ) != NULL ? rf_json_number_of( frame, "relmse_likely" ) : 0.0;
    }
    if ( count == 0 )
        return NULL;
    json_t *kinds = no_kinds(), *materials = json_array();
    json_array_foreach( frames, i, frame )
    {
        const json_t* specks = specks_of( frame );
        if ( specks == NULL )
            continue;
        double weight = likely > 0.0 ? rf_json_number_of( frame, "relmse_likely" ) / likely : 0.0;
        pixels += at_least_0( rf_json_number_of( specks, "pixels" ) );
        share += weight * at_least_0( rf_json_number_of( specks, "share" ) );
        rest += rf_json_number_of( specks, "rest_relmse" ) / count;
        add_materials( specks, weight, kinds, materials );
    }
    sort_rows( materials );
    json_t* sum = head_json( (int64_t)pixels, share, rest );
    json_object_set_new( sum, "kinds", kinds );
    json_object_set_new( sum, "materials", materials );
    json_object_set_new( sum, "frames", json_integer( count ) );
    return sum;
}

static double share_of_kind( const json_t* sum, RfSpeckKind kind )
{
    return rf_json_number_of( json_object_get( json_object_get( sum, "kinds" ), rf_speck_kind_name( kind ) ), "share" );
}

// The kind that most of the specks' error is of; RF_SPECK_OTHER: there is none, or it is that.
static RfSpeckKind main_kind( const json_t* sum )
{
    double all = rf_json_number_of( sum, "share" );
    for ( int k = 0; k < RF_SPECK_OTHER; ++k )
    {
        if ( isgreaterequal( share_of_kind( sum, (RfSpeckKind)k ), MOSTLY * all ) )
            return (RfSpeckKind)k;
    }
    return RF_SPECK_OTHER;
}

// ", mostly on 'steel' (glints)"; the material and the kind only where most of the error has them.
static void format_main_part( const json_t* sum, char* text, size_t size )
{
    static const char* const words[RF_SPECK_KINDS] = { "glints", "caustics found by chance", "" };
    const json_t *first = json_array_get( json_object_get( sum, "materials" ), 0 ), *row;
    const char* kind = words[main_kind( sum )];
    char place[96] = "";
    double share = 0.0;
    size_t i;
    json_array_foreach( json_object_get( sum, "materials" ), i, row )
    {
        if ( json_equal( json_object_get( row, "material" ), json_object_get( first, "material" ) ) )
            share += at_least_0( rf_json_number_of( row, "share" ) );
    }
    const char* name = json_string_value( json_object_get( first, "material" ) );
    if ( first != NULL && isgreaterequal( share, MOSTLY * rf_json_number_of( sum, "share" ) ) )
        snprintf( place, sizeof place, " %s%.60s%s", name != NULL ? "on '" : "in the sky", name != NULL ? name : "",
                  name != NULL ? "'" : "" );
    if ( place[0] != '\0' )
        snprintf( text, size, ", mostly%s%s%s%s", place, kind[0] != '\0' ? " (" : "", kind, kind[0] != '\0' ? ")" : "" );
    else
        snprintf( text, size, "%s%s", kind[0] != '\0' ? ", mostly " : "", kind );
}

bool rf_format_specks( const json_t* sum, char* text, size_t size )
{
    double pixels = rf_json_number_of( sum, "pixels" ), share = rf_json_number_of( sum, "share" );
    double frames = rf_json_number_of( sum, "frames" ), rest = rf_json_number_of( sum, "rest_relmse" );
    if ( !isgreater( pixels, 0.0 ) || !isgreaterequal( share, RF_SPECKS_STAND_OUT ) )
        return false;
    char noise[RF_NOISE_TEXT_SIZE], in_frames[48] = "", percent[32], part[192];
    rf_format_noise( rest, noise );
    if ( frames > 1.0 )
        snprintf( in_frames, sizeof in_frames, " in %.0f frames", frames );
    snprintf( percent, sizeof percent, "%.0f %%", floor( 100.0 * share ) );
    format_main_part( sum, part, sizeof part );
    snprintf( text, size, "%.0f speck%s%s hold%s %s of the error%s; the rest has about %s noise (relMSE %.3g)", pixels,
              pixels > 1.0 ? "s" : "", in_frames, pixels > 1.0 ? "" : "s", percent, part, noise, rest );
    return true;
}

const char* rf_speck_advice( const json_t* sum, const RfRenderSettings* settings )
{
    bool adapts = settings->estimator->add_own_shares != NULL && settings->group != 0;
    switch ( main_kind( sum ) )
    {
        case RF_SPECK_GLINT: return adapts && settings->adaptive == RF_ADAPTIVE_OFF ? "--adaptive" : "raise --spp";
        case RF_SPECK_CHANCE: return settings->estimator->clamps && settings->clamp == 0.0 ? "--clamp auto" : NULL;
        case RF_SPECK_OTHER: break;
    }
    return NULL;
}
