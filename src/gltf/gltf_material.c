// Materials and their extensions, except for textures: what the document says, then what a scene file says in its place, and the
// scattering model that comes of both.
//
// `extras.reframe` may have a scattering model that glTF lacks:
//
//     {"bsdf": "phong", "diffuse": [r, g, b], "specular": [r, g, b], "exponent": 60}
//     {"bsdf": "lambert", "diffuse": [r, g, b]}
//     {"bsdf": "mirror", "specular": [r, g, b]}
//     {"bsdf": "glass", "ior": 1.5}
//     {"coat": "added"}: glTF's own model, with a coat that takes nothing from the base, as in Blender's Principled
//
// and beside either or alone {"pass_index": 3}, for compositors, and {"light_group": "key"}, of what it emits.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include "scene/shared_json.h"
#include "scene/placement.h"

#include <math.h>
#include <string.h>

#define BESIDE "pass_index", "light_group"

// A model, its keys and its alpha. A reflectance is required where there is a key for it.
struct RfGltfModel
{
    const char* name;
    const char* keys[7];
    RfBsdfKind kind;
    float alpha;
};

static const RfGltfModel s_models[] = {
    { "phong", { "bsdf", "diffuse", "specular", "exponent", BESIDE, NULL }, RF_BSDF_PHONG, 1.0f },
    { "lambert", { "bsdf", "diffuse", BESIDE, NULL }, RF_BSDF_LAMBERT, 1.0f },
    { "mirror", { "bsdf", "specular", BESIDE, NULL }, RF_BSDF_GLASS, 0.0f },
    { "glass", { "bsdf", "ior", BESIDE, NULL }, RF_BSDF_GLASS, 0.0f }, // solid, smooth and clear
};

static bool is_one_of( const char* key, const char* const* keys )
{
    while ( *keys != NULL && strcmp( key, *keys ) != 0 )
        ++keys;
    return *keys != NULL;
}

static bool has_only( const json_t* own, const char* const* keys )
{
    const char* key;
    json_t* value;
    bool all = true;
    json_object_foreach( (json_t*)own, key, value ) all = all && is_one_of( key, keys );
    return all;
}

// Is the scattering model glTF's? `coat` says how its layers are joined.
static bool keeps_model( const json_t* own )
{
    static const char* const s_beside[] = { BESIDE, NULL };
    return ( json_object_size( own ) > 0 && has_only( own, s_beside ) ) ||
           ( json_object_get( own, "bsdf" ) == NULL && json_object_get( own, "coat" ) != NULL );
}

static RfResult fail_other_bsdf( const RfField* field, const RfGltfMaterial* m )
{
    return rf_field_fail( field, "has no effect on bsdf \"%.20s\": add \"bsdf\": \"gltf\"", m->model->name );
}

// Scene files give phong and lambert their lobes, and choose among them and glTF's own.
static RfResult check_edit( const RfGltfMaterial* m )
{
    static const char* const s_keys[] = { "diffuse", "specular", "exponent" };
    RfField film = rf_field_member( &m->edit, "metallicRoughnessTexture" );
    for ( int i = 0; i < 3; ++i )
    {
        RfField field = rf_field_member( &m->edit, s_keys[i] );
        bool has = m->model != NULL && m->model->kind != RF_BSDF_GLASS && is_one_of( s_keys[i], m->model->keys );
        if ( field.json != NULL && !has )
            return rf_field_fail( &field,
                                  "has no effect on bsdf \"%.20s\": add \"bsdf\": \"phong\" with diffuse, specular and exponent",
                                  m->model != NULL ? m->model->name : "gltf" );
        if ( has && m->chosen )
            rf_field_require( &m->edit, s_keys[i], i == 2 ? "a number from 0 to 1e+06" : "an array of 3 numbers" );
    }
    return film.json != NULL && m->model != NULL ? fail_other_bsdf( &film, m ) : rf_json_result( &m->edit );
}

static RfResult find_model( RfGltfMaterial* m )
{
    static const char* const s_bsdfs[] = { "gltf", "lambert", "phong", NULL };
    const RfGltfModel *model = s_models, *end = s_models + sizeof s_models / sizeof s_models[0];
    const char* bsdf = json_string_value( json_object_get( m->own.json, "bsdf" ) );
    int chosen = 0;
    m->chosen = rf_has_member( &m->edit, "bsdf" );
    if ( rf_get_choice( &m->edit, "bsdf", s_bsdfs, &chosen ) != RF_OK )
        return rf_json_result( &m->edit );
    if ( m->chosen ? chosen == 0 : m->own.json == NULL || keeps_model( m->own.json ) )
        return check_edit( m );
    bsdf = m->chosen ? s_bsdfs[chosen] : bsdf;
    while ( bsdf != NULL && model < end && strcmp( bsdf, model->name ) != 0 )
        ++model;
    if ( bsdf == NULL || model == end )
        return rf_field_fail( &m->own, "must be an object with bsdf \"lambert\", \"phong\", \"mirror\" or \"glass\"" );
    m->model = model;
    return check_edit( m );
}

static RfResult open_material( RfGltf* gltf, int index, RfGltfMaterial* out )
{
    *out = ( RfGltfMaterial ){ .index = index, .json = rf_gltf_item_field( gltf, RF_GLTF_MATERIALS, index ), .textures = true };
    out->own = rf_gltf_extras( &out->json );
    out->edit = gltf->material_edits != NULL ? gltf->material_edits[index] : rf_make_field( "", "", NULL, gltf->error );
    out->edit.error = gltf->error;
    out->unlit = rf_gltf_extension( &out->json, "KHR_materials_unlit" ).json != NULL;
    out->glossiness = rf_gltf_extension( &out->json, "KHR_materials_pbrSpecularGlossiness" );
    rf_get_bool( &out->edit, "textures", &out->textures );
    return find_model( out );
}

// How the layers of glTF's own model are joined, and numbers for compositors.
static void read_extras( RfGltfMaterial* m, RfFactors* factors, RfMaterial* out )
{
    static const char* const s_keys[] = { "coat", BESIDE, NULL };
    RfField own = m->own;
    const char* coat = json_string_value( json_object_get( own.json, "coat" ) );
    int64_t index = 0;
    if ( !m->chosen && keeps_model( own.json ) && rf_has_member( &own, "coat" ) )
    {
        if ( !has_only( own.json, s_keys ) || coat == NULL || strcmp( coat, "added" ) != 0 )
            rf_field_fail( &own, "must have coat \"added\" and nothing else, or a bsdf" );
        factors->coat_is_added = true;
    }
    own.gltf = true;
    rf_get_integer( &own, "pass_index", 0, RF_MOST_PASS_INDEX, &index );
    out->pass_index = (unsigned int)index & RF_MOST_PASS_INDEX;
}

static void read_reflectance( const RfGltfMaterial* m, const char* key, double rgb[3] )
{
    if ( !is_one_of( key, m->model->keys ) )
        return;
    if ( !rf_has_member( &m->edit, key ) )
        rf_field_require( &m->own, key, "three numbers from 0 to 1" );
    rf_get_numbers( rf_has_member( &m->edit, key ) ? &m->edit : &m->own, key, rf_range( 0.0, 1.0 ), 3, rgb );
}

static RfResult check_energy( const RfGltfMaterial* m, const double diffuse[3], const double specular[3] )
{
    for ( int i = 0; i < 3; ++i )
    {
        double sum = diffuse[i] + specular[i];
        // the rounding of decimal fractions that sum to one does not violate energy conservation
        if ( sum > 1.0 + 1e-6 && m->edit.json != NULL )
            return rf_field_fail( &m->edit, "diffuse + specular reflect %g of the incident light: lower their sum to 1 or less",
                                  sum );
        if ( sum > 1.0 + 1e-6 )
            return rf_field_fail( &m->own, "diffuse + specular reflect more light than arrives: lower their sum to 1 or less" );
    }
    return rf_json_result( &m->json );
}

static RfResult read_own_model( const RfGltfMaterial* m, RfMaterial* out )
{
    const RfGltfModel* model = m->model;
    double diffuse[3] = { 0 }, specular[3] = { 0 }, exponent = 0.0, ior = 1.5;
    if ( model == NULL )
        return rf_json_result( &m->json );
    if ( !m->chosen )
        rf_field_keys( &m->own, model->keys );
    read_reflectance( m, "diffuse", diffuse );
    read_reflectance( m, "specular", specular );
    const RfField* shape = rf_has_member( &m->edit, "exponent" ) ? &m->edit : &m->own;
    if ( model->kind == RF_BSDF_PHONG )
    {
        rf_field_require( shape, "exponent", "a number from 0 to 1000000" );
        rf_get_number( shape, "exponent", rf_range( 0.0, 1e6 ), &exponent );
    }
    bool clear = is_one_of( "ior", model->keys );
    if ( clear )
        rf_get_number( &m->own, "ior", rf_above( 1.0, 10.0 ), &ior );
    float through = clear ? 1.0f : 0.0f;
    out->diffuse = rf_vec3_of( diffuse, 1.0 );
    out->specular = rf_vec3_of( specular, 1.0 );
    out->kind = model->kind;
    out->alpha = model->alpha;
    out->exponent = model->kind == RF_BSDF_PHONG ? (float)exponent : out->exponent;
    out->f90 = out->coat_f0 = out->coat_f90 = 0.0f;
    out->tint = rf_vec3( through, through, through );
    out->absorption = rf_vec3( 0.0f, 0.0f, 0.0f );
    out->ior = clear ? (float)ior : 0.0f;
    out->thin = false;
    return check_energy( m, diffuse, specular );
}

// Glass and mirrors: KHR_materials_transmission with _volume, metals without roughness; also
// KHR_materials_unlit.

// −ln(colour) / distance; a channel of 0 is fully absorbed.
static float absorption( double color, double distance )
{
    double a = -log( fmax( color, 1e-6 ) ) / distance;
    return isfinite( a ) ? (float)fmin( a, 1e6 ) : 0.0f;
}

static void make_glass( const RfMaterialValues* in, RfMaterial* out )
{
    const RfFactors* factors = &in->lobes;
    out->kind = RF_BSDF_GLASS;
    // by the extension, an index of 0 means total reflection
    out->ior = factors->ior > 0.0 ? (float)fmax( factors->ior, 1.0001 ) : 1e4f;
    out->thin = in->thickness == 0.0;
    rf_derive_glass( factors, in->transmission, out );
    if ( out->thin )
        return;
    const double *color = in->attenuation_color, distance = in->attenuation_distance;
    out->absorption =
        rf_vec3( absorption( color[0], distance ), absorption( color[1], distance ), absorption( color[2], distance ) );
}

// A surface that looks the same in any light, and sheds none: its base colour.
static void make_unlit( const double base[3], RfMaterial* out )
{
    out->kind = RF_BSDF_LAMBERT;
    out->diffuse = rf_vec3( 0.0f, 0.0f, 0.0f );
    out->emission = rf_vec3_of( base, 1.0 );
    out->unlit = true;
}

// True for a metal by its factors, unless a texture varies it.
static bool is_all_metal( const RfGltfMaterial* m, const RfFactors* factors )
{
    return factors->metallic == 1.0 && !rf_gltf_has_texture( m, RF_TEXTURE_METALLIC_ROUGHNESS );
}

// Applies KHR_materials_transmission, _volume and _unlit, and finds metals without roughness, after all other factors.
// `reshapes`: its roughness or metallic factor change, so that it is no metal or mirror at all times. `dense`: it scatters inside,
// and is taken for opaque.
static void apply_glass( const RfGltfMaterial* m, const RfMaterialValues* values, bool reshapes, bool dense, RfMaterial* out )
{
    const RfFactors* factors = &values->lobes;
    if ( m->unlit )
        make_unlit( factors->base, out );
    else if ( values->transmission > 0.0 && !dense && ( reshapes || !is_all_metal( m, factors ) ) )
        make_glass( values, out );
    else if ( !reshapes && factors->metallic == 1.0 && factors->roughness < RF_SMOOTH_ROUGHNESS )
    {
        out->kind = RF_BSDF_GLASS;
        out->alpha = 0.0f;
    }
}

// KHR_materials_clearcoat: a clear coat over the metallic-roughness model.

// The last of the extensions.
static void apply_clearcoat( RfGltf* gltf, const RfGltfMaterial* m, const RfMaterialValues* values, RfMaterial* out )
{
    // unlit materials ignore it
    if ( values->clearcoat == 0.0 || m->unlit )
        return;
    if ( out->kind >= RF_BSDF_FIRST_SPECULAR )
    {
        rf_gltf_notice( gltf, "a clear coat over glass or a mirror is not supported: material '%.80s' is without it", out->name );
        return;
    }
    if ( out->kind == RF_BSDF_TRANSLUCENT )
    {
        rf_gltf_notice( gltf, "a clear coat over diffuse transmission is not supported: material '%.80s' is without it",
                        out->name );
        return;
    }
    rf_derive_clearcoat( values->clearcoat, values->clearcoat_roughness, out );
    rf_choose_layers( out );
}

// Does light go through the base of an opaque material? Not of a metal, unless a texture varies that.
static bool is_translucent( const RfGltfMaterial* m, const RfFactors* factors, const RfMaterial* out )
{
    return factors->through > 0.0 && out->kind < RF_BSDF_FIRST_SPECULAR &&
           ( factors->metallic < 1.0 || rf_gltf_has_texture( m, RF_TEXTURE_METALLIC_ROUGHNESS ) );
}

// What a translucent material has beyond what its model knows.
static void make_translucent( RfGltf* gltf, const RfMaterialValues* values, RfMaterial* out )
{
    RfMaterial layered = *out;
    rf_choose_layers( &layered );
    if ( layered.kind != RF_BSDF_GGX )
        rf_gltf_notice( gltf,
                        "sheen, anisotropy and films on a surface with diffuse transmission are not supported: material '%.80s' "
                        "is without them",
                        out->name );
    if ( values->thickness > 0.0 && values->attenuation_distance < HUGE_VAL )
        rf_gltf_notice( gltf,
                        "absorption inside a body with diffuse transmission is not supported: material '%.80s' is clear inside",
                        out->name );
    out->kind = RF_BSDF_TRANSLUCENT;
}

// The least extinction of the channels, 1/m: what KHR_materials_volume calls attenuation. 0 without any.
static double least_extinction( const RfMaterialValues* values )
{
    const double* color = values->attenuation_color;
    return -log( fmax( fmax( color[0], fmax( color[1], color[2] ) ), 1e-6 ) ) / values->attenuation_distance;
}

// The albedo of a half-space that is lit evenly, from that which KHR_materials_volume_scatter takes for it: its single-scattering
// albedo is 1 − s², whatever g is, which is as bright as an even phase function of 1 − s² / (1 − g (1 − s²)). The inverse of s(A)
// is that of the extension's fit, whose squares cancel to 2e-6.
static double albedo_of_half_space( double multiscatter, double g )
{
    double a = multiscatter, s = 4.09712 + 4.20863 * a - sqrt( 9.59217 + 41.6808 * a + 17.7126 * a * a );
    double even = s / sqrt( 1.0 - g * ( 1.0 - s * s ) ), u = 4.09712 - even;
    return g == 0.0 ? a : fmin( fmax( ( u * u - 9.59217 ) / ( 41.6808 - 2.0 * 4.20863 * u ), 0.0 ), 1.0 );
}

// What a half-space with a boundary reflects: on either side it reflects `base` and lets `in` through, all of it diffuse.
static double reflected( double base, double in, double albedo )
{
    return base + in * in * albedo / fmax( 1.0 - base * albedo, 1e-9 );
}

// KHR_materials_volume_scatter: where a body is dense, `dense` is set, and its values become those of an opaque surface with the
// albedo of a half-space of what is inside (src/reuse/estimators.md, section 21).
static RfResult apply_scatter( const RfGltfMaterial* m, RfMaterialValues* values, bool* dense )
{
    RfFactors* factors = &values->lobes;
    RfField json = rf_gltf_extension( &m->json, "KHR_materials_volume_scatter" );
    double g = values->scatter_anisotropy, clear = values->transmission;
    *dense = false;
    if ( json.json == NULL )
        return rf_json_result( &m->json );
    if ( !( g > -1.0 && g < 1.0 ) )
        return rf_field_fail( &json, "scatterAnisotropy is %g, it must be between -1 and 1", g );
    if ( factors->metallic > 0.0 || m->unlit || m->model != NULL )
        return RF_OK;
    // by the extension, diffuse transmission says that a body is dense
    double extinction = least_extinction( values );
    *dense = clear > 0.0 ? extinction * values->thickness >= 1.0 : factors->through > 0.0 && extinction > 0.0;
    for ( int i = 0; i < 3 && *dense; ++i )
    {
        double through = clear > 0.0 ? clear * factors->base[i] : factors->through * factors->through_color[i];
        double left = 1.0 - ( clear > 0.0 ? clear : factors->through );
        factors->base[i] = reflected( left * factors->base[i], through, albedo_of_half_space( values->multiscatter[i], g ) );
    }
    factors->through = *dense ? 0.0 : factors->through;
    return RF_OK;
}

// What extensions do, after glass and before the coat, that lay something over the metallic-roughness model or change its lobes.
static void apply_surface( RfGltf* gltf, const RfGltfMaterial* m, const RfMaterialValues* values, RfMaterial* out )
{
    const RfFactors* factors = &values->lobes;
    if ( m->unlit || m->model != NULL )
        return;
    rf_derive_layers( factors, out );
    bool mirror = out->kind == RF_BSDF_GLASS && out->ior == 0.0f;
    if ( out->kind == RF_BSDF_GLASS && !mirror )
    {
        if ( rf_max_component( out->sheen ) > 0.0f )
            rf_gltf_notice( gltf, "sheen over glass is not supported: material '%.80s' is without it", out->name );
        if ( out->anisotropy > 0.0f )
            rf_gltf_notice( gltf, "anisotropy of glass is not supported: material '%.80s' is isotropic", out->name );
        bool opaque = values->transmission < 1.0 || rf_gltf_has_texture( m, RF_TEXTURE_TRANSMISSION );
        if ( factors->through > 0.0 && opaque ) // else transmission overrides it
            rf_gltf_notice( gltf,
                            "diffuse transmission of glass is not supported: the opaque part of material '%.80s' is without it",
                            out->name );
        out->dispersion = out->thin ? 0.0f : (float)factors->dispersion; // what has no volume does not refract
        if ( out->film > 0.0f || out->dispersion > 0.0f )
            out->kind = RF_BSDF_SPECTRAL;
        return;
    }
    if ( is_translucent( m, factors, out ) )
    {
        make_translucent( gltf, values, out );
        return;
    }
    RfMaterial layered = *out;
    rf_choose_layers( &layered );
    if ( layered.kind == RF_BSDF_GGX || ( out->kind == RF_BSDF_LAMBERT && layered.kind == RF_BSDF_ANISOTROPIC ) )
        return;
    if ( mirror && layered.kind == RF_BSDF_IRIDESCENT )
        layered.kind = RF_BSDF_SPECTRAL;
    else if ( mirror ) // not a perfect one
        rf_derive_lobes( factors, &layered );
    *out = layered;
}

// Materials: glTF's metallic-roughness model as a Lambert base under a GGX lobe, with
// KHR_materials_specular, _ior and _emissive_strength.

static RfMaterialValues default_values( void )
{
    return ( RfMaterialValues ){
        .lobes = { .base = { 1, 1, 1, 1 },
                   .metallic = 1,
                   .roughness = 1,
                   .specular = 1,
                   .specular_color = { 1, 1, 1 },
                   .ior = 1.5,
                   .film_ior = 1.3,
                   .film_least = 100,
                   .film_most = 400,
                   .through_color = { 1, 1, 1 } },
        .strength = 1,
        .attenuation_distance = (double)INFINITY,
        .attenuation_color = { 1, 1, 1 },
        .alpha_cutoff = 0.5,
    };
}

static void apply_factors( const RfMaterialValues* in, bool reshapes, RfMaterial* out )
{
    rf_derive_lobes( &in->lobes, out );
    out->kind = !reshapes && in->lobes.metallic == 0.0 && in->lobes.specular == 0.0 ? RF_BSDF_LAMBERT : RF_BSDF_GGX;
    out->emission = rf_emission_of( in );
}

// KHR_materials_pbrSpecularGlossiness, taken for what means the same: a non-metal whose reflectance at normal incidence is the
// specular colour (which an index of refraction of 0 makes the colour of KHR_materials_specular), with a roughness of
// 1 − glossiness. The light that the base gets differs: it is what GGX lets through, not 1 − max(specular).
static void read_glossiness( const RfGltfMaterial* m, RfFactors* factors )
{
    const RfRange share = rf_range( 0.0, 1.0 );
    const RfFactors none = default_values().lobes;
    double glossiness = 1.0;
    if ( m->glossiness.json == NULL )
        return;
    memcpy( factors->base, none.base, sizeof none.base );
    memcpy( factors->specular_color, none.specular_color, sizeof none.specular_color );
    rf_get_numbers( &m->glossiness, "diffuseFactor", share, 4, factors->base );
    rf_get_numbers( &m->glossiness, "specularFactor", share, 3, factors->specular_color );
    rf_get_number( &m->glossiness, "glossinessFactor", share, &glossiness );
    factors->metallic = factors->ior = 0.0;
    factors->specular = 1.0;
    factors->roughness = 1.0 - glossiness;
}

// The numbers that a scene file gives it.
static RfResult read_edit( const RfGltfMaterial* m, RfMaterialValues* values )
{
    for ( RfChangedValue v = rf_next_value( RF_OF_MATERIAL, -1 ); m->edit.json != NULL && v < RF_CHANGED_COUNT;
          v = rf_next_value( RF_OF_MATERIAL, v ) )
    {
        const RfChangedTraits* traits = rf_changed_traits( v );
        RfField field = rf_field_member( &m->edit, traits->name );
        RfKeyed kind = rf_keyed_value( v );
        if ( field.json == NULL || ( traits->flags & RF_VALUE_IN_FILE ) == 0 )
            continue;
        if ( m->model != NULL && ( traits->flags & RF_VALUE_OF_MODEL ) != 0 )
            return fail_other_bsdf( &field, m );
        rf_read_keyed( &field, &kind, rf_value_in( values, v ) );
    }
    return rf_json_result( &m->edit );
}

#define MOST_KEYED 8

// Adds a channel of keys that a scene file gives a material.
static RfResult add_keys( RfGltf* gltf, const RfGltfMaterial* m, RfChangedValue value, const RfChannel* channel )
{
    const RfChangedTraits* traits = rf_changed_traits( value );
    RfField keys = rf_field_member( &m->edit, "keys" );
    RfChange change = { .value = value, .of = m->index, .channel = *channel };
    if ( m->model != NULL && ( traits->flags & RF_VALUE_OF_MODEL ) != 0 )
        return rf_field_fail( &keys, "%s has no effect on another bsdf: add \"bsdf\": \"gltf\"", traits->name );
    return rf_gltf_add_change( gltf, &change );
}

RfResult rf_gltf_read_keys( RfGltf* gltf, int material )
{
    RfGltfMaterial m;
    RfChannel channels[MOST_KEYED] = { { 0 } };
    RfKeyed kinds[MOST_KEYED];
    RfChangedValue values[MOST_KEYED];
    int count = 0;
    bool in_frames = false;
    for ( RfChangedValue v = rf_next_value( RF_OF_MATERIAL, -1 ); v < RF_CHANGED_COUNT && count < MOST_KEYED;
          v = rf_next_value( RF_OF_MATERIAL, v ) )
    {
        kinds[count] = rf_keyed_value( v );
        values[count] = v;
        count += ( rf_changed_traits( v )->flags & RF_VALUE_KEYED ) != 0;
    }
    RfFps fps = gltf->options->fps.numerator > 0 ? gltf->options->fps : rf_gltf_document_fps( gltf->root );
    RfResult result = open_material( gltf, material, &m );
    if ( result == RF_OK )
        result = rf_read_keys( &m.edit, fps, kinds, count, channels, &in_frames );
    for ( int i = 0; i < count; ++i )
    {
        bool given = result == RF_OK && channels[i].count > 0;
        if ( given )
            result = add_keys( gltf, &m, values[i], channels + i );
        if ( !given || result != RF_OK )
            rf_destroy_channel( channels + i );
    }
    if ( in_frames && gltf->options->in_frames != NULL )
        *gltf->options->in_frames = true;
    return result;
}

static RfResult read_values( RfGltf* gltf, RfGltfMaterial* m, RfMaterialValues* values, RfMaterial* out )
{
    int tag;
    rf_gltf_copy_name( &m->json, m->json.path, &out->name );
    rf_gltf_read_values( gltf, &m->json, RF_OF_MATERIAL, values );
    read_glossiness( m, &values->lobes );
    read_edit( m, values );
    // by the extension, 0 means total reflection
    if ( values->lobes.ior != 0.0 && values->lobes.ior < 1.0 )
        rf_gltf_fail( gltf, RF_ERROR_FORMAT, rf_where( "%s.extensions.KHR_materials_ior", m->json.path ).text,
                      "ior is %g, it must be 0, or 1 and above", values->lobes.ior );
    read_extras( m, &values->lobes, out );
    rf_get_bool( &m->json, "doubleSided", &out->double_sided );
    rf_get_bool( &m->edit, "doubleSided", &out->double_sided );
    RfResult result = rf_gltf_read_tag( gltf, rf_has_member( &m->edit, "light_group" ) ? &m->edit : &m->own, &tag );
    out->light_group = (uint16_t)( tag > 0 ? tag : 0 );
    return result;
}

static RfResult load_material( RfGltf* gltf, int index, RfMaterial* out )
{
    RfGltfMaterial m;
    RfMovingMaterial moving = { .material = index, .values = default_values() };
    RfMaterialValues *values = &moving.values, most;
    int changes[RF_CHANGED_COUNT];
    RF_TRY( open_material( gltf, index, &m ) );
    RF_TRY( read_values( gltf, &m, values, out ) );
    rf_gltf_notice_extensions( gltf, &m.json, "material", out->name );
    most = *values;
    rf_gltf_find_changes( gltf, RF_OF_MATERIAL, index, values, &most, changes );
    bool dense = false, reshapes = changes[RF_CHANGED_METALLIC] >= 0 || changes[RF_CHANGED_ROUGHNESS] >= 0;
    RF_TRY( apply_scatter( &m, values, &dense ) );
    apply_factors( values, reshapes, out );
    out->emission = rf_emission_of( &most );
    apply_glass( &m, values, reshapes, dense, out );
    apply_surface( gltf, &m, values, out );
    apply_clearcoat( gltf, &m, values, out );
    RF_TRY( read_own_model( &m, out ) );
    RF_TRY( rf_gltf_read_textured( gltf, &m, &moving, out ) );
    return rf_gltf_change_material( gltf, &moving, out );
}

RfResult rf_gltf_load_materials( RfGltf* gltf )
{
    int count = gltf->counts[RF_GLTF_MATERIALS];
    // one more: the default material for primitives without one
    RF_TRY( rf_gltf_allocate( gltf, "materials", &gltf->scene->materials, (size_t)count, sizeof *gltf->scene->materials ) );
    gltf->scene->material_count = (uint32_t)count;
    for ( int i = 0; i < count; ++i )
        RF_TRY( load_material( gltf, i, gltf->scene->materials + i ) );
    return RF_OK;
}

RfResult rf_gltf_use_default_material( RfGltf* gltf, uint32_t* index )
{
    if ( gltf->default_material < 0 )
    {
        RfMaterial* material = gltf->scene->materials + gltf->scene->material_count;
        material->name = strdup( "default" );
        if ( material->name == NULL )
            return rf_gltf_no_memory( gltf, "materials" );
        RfMaterialValues values = default_values();
        apply_factors( &values, false, material );
        material->textured = rf_gltf_textured( &values.lobes );
        if ( material->textured == NULL )
            return rf_gltf_no_memory( gltf, "materials" );
        material->textured->optional = true; // for primitives with vertex colours
        gltf->default_material = (int)gltf->scene->material_count++;
    }
    *index = (uint32_t)gltf->default_material;
    return RF_OK;
}
