// What changes by keys and is not of a node: the list of it, and its way into the scene.
#include "base/try.h"
#include "gltf/gltf_document.h"

#include "scene/placement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A value by its range, into which it is rounded; `name` is what messages call it.
static RfResult check_value( const RfGltf* gltf, const char* where, const char* name, const RfChangedTraits* traits, double* at )
{
    RfRange range = { traits->low, traits->high, ( traits->flags & RF_VALUE_ABOVE ) != 0 };
    double value = *at = rf_round_into( range, *at );
    RfField field = rf_gltf_field( gltf, rf_where( "%s.%s", where, name ).text, NULL );
    field.owner = (int)strlen( where );
    return ( traits->flags & RF_VALUE_LIMITED ) != 0 && fabs( value ) > traits->high
               ? rf_gltf_check_limit( gltf, where, name, value, traits->high )
               : rf_field_check( &field, range, value );
}

RfResult rf_gltf_read_value( const RfGltf* gltf, const RfField* home, RfChangedValue value, void* values )
{
    const RfChangedTraits* traits = rf_changed_traits( value );
    double* to = rf_value_in( values, value );
    if ( traits->components > 1 )
        rf_get_numbers( home, traits->name, rf_any_number(), traits->components, to );
    else
        rf_get_number( home, traits->name, rf_any_number(), to );
    for ( int i = 0; i < traits->components && rf_has_member( home, traits->name ); ++i )
        check_value( gltf, home->path, traits->name, traits, to + i );
    return rf_json_result( home );
}

RfResult rf_gltf_read_values( const RfGltf* gltf, const RfField* owner, RfValueOwner kind, void* values )
{
    const char* name = NULL;
    RfField home = *owner;
    for ( RfChangedValue v = rf_next_value( kind, -1 ); v < RF_CHANGED_COUNT; v = rf_next_value( kind, v ) )
    {
        if ( rf_changed_traits( v )->home != name ) // values of one place follow each other
            home = rf_gltf_home( owner, rf_changed_traits( v )->home );
        name = rf_changed_traits( v )->home;
        rf_gltf_read_value( gltf, &home, v, values );
    }
    return rf_json_result( owner );
}

RfResult rf_gltf_check_change( const RfGltf* gltf, const char* where, const RfChange* change )
{
    const RfChannel* channel = &change->channel;
    const RfChangedTraits* traits = rf_changed_traits( change->value );
    size_t n = (size_t)channel->components, per_key = channel->interpolation == RF_CUBICSPLINE ? 3 * n : n;
    double* values = channel->values + ( per_key > n ? n : 0 );
    RfWhere name = rf_where( "%s of the output", traits->name );
    for ( size_t k = 0; k < (size_t)channel->count; ++k )
    {
        for ( size_t i = 0; i < n; ++i )
            RF_TRY( check_value( gltf, where, name.text, traits, values + k * per_key + i ) );
    }
    return RF_OK;
}

RfResult rf_gltf_add_change( RfGltf* gltf, const RfChange* change )
{
    if ( !rf_gltf_grow( &gltf->changes, gltf->change_count, sizeof *gltf->changes ) )
        return rf_gltf_no_memory( gltf, "animations" );
    gltf->changes[gltf->change_count++] = *change;
    return RF_OK;
}

// Materials go with their textures.
static int group_of( RfChangedValue value )
{
    RfValueOwner owner = rf_changed_traits( value )->owner;
    return owner == RF_OF_TEXTURE ? (int)RF_OF_MATERIAL : (int)owner;
}

static int compare( const void* a, const void* b )
{
    const RfChange *x = a, *y = b;
    int keys[2][4] = { { group_of( x->value ), x->of, (int)x->value, x->slot },
                       { group_of( y->value ), y->of, (int)y->value, y->slot } };
    for ( int i = 0; i < 4; ++i )
    {
        if ( keys[0][i] != keys[1][i] )
            return keys[0][i] < keys[1][i] ? -1 : 1;
    }
    return 0;
}

RfResult rf_gltf_sort_changes( RfGltf* gltf )
{
    RfScene* scene = gltf->scene;
    if ( gltf->change_count == 0 )
        return RF_OK;
    qsort( gltf->changes, (size_t)gltf->change_count, sizeof *gltf->changes, compare );
    double first = (double)INFINITY, last = -(double)INFINITY;
    for ( int i = 0; i < gltf->change_count; ++i )
    {
        double start, end;
        rf_channel_span( &gltf->changes[i].channel, &start, &end );
        first = fmin( first, start );
        last = fmax( last, end );
    }
    scene->change_start = first;
    scene->change_end = last;
    gltf->change_used = calloc( (size_t)gltf->change_count, sizeof *gltf->change_used );
    return gltf->change_used != NULL ? RF_OK : rf_gltf_no_memory( gltf, "animations" );
}

void rf_gltf_free_changes( RfGltf* gltf )
{
    for ( int i = 0; i < gltf->change_count; ++i )
        rf_destroy_channel( &gltf->changes[i].channel );
    free( gltf->changes );
    free( gltf->change_used );
    free( gltf->lamps );
    free( gltf->moving_materials );
}

// The first change that does not come before that of a value.
static int lower_bound( const RfGltf* gltf, RfChangedValue value, int of, int slot )
{
    const RfChange wanted = { .value = value, .of = of, .slot = slot };
    int low = 0, high = gltf->change_count;
    while ( low < high )
    {
        int middle = low + ( high - low ) / 2;
        if ( compare( gltf->changes + middle, &wanted ) < 0 )
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

int rf_gltf_find_change( const RfGltf* gltf, RfChangedValue value, int of, int slot, double* still )
{
    int at = lower_bound( gltf, value, of, slot );
    const RfChange* found = at < gltf->change_count ? gltf->changes + at : NULL;
    if ( found == NULL || found->value != value || found->of != of || found->slot != slot )
        return -1;
    bool frozen = gltf->freeze && group_of( value ) != (int)RF_OF_CAMERA; // cameras never are
    if ( !frozen && rf_channel_varies( &found->channel ) )
        return at;
    double values[4];
    rf_sample_change( found, frozen ? gltf->frozen_at : 0.0, values );
    memcpy( still, values, (size_t)found->channel.components * sizeof *still );
    return -1;
}

void rf_gltf_find_changes( const RfGltf* gltf, RfValueOwner owner, int of, void* still, void* most, int* changes )
{
    for ( RfChangedValue v = rf_next_value( owner, -1 ); v < RF_CHANGED_COUNT; v = rf_next_value( owner, v ) )
    {
        double all[4];
        double* own = rf_value_in( still, v );
        changes[v] = rf_gltf_find_change( gltf, v, of, 0, own );
        if ( changes[v] >= 0 )
            rf_most_of_change( gltf->changes + changes[v], all );
        memcpy( rf_value_in( most, v ), changes[v] >= 0 ? all : own, (size_t)rf_changed_traits( v )->components * sizeof *all );
    }
}

bool rf_gltf_light_changes( const RfGltf* gltf, int index )
{
    for ( int i = 0; i < gltf->change_count; ++i )
    {
        const RfChange* change = gltf->changes + i;
        bool varies = gltf->change_used[i] || rf_channel_varies( &change->channel ); // whose keys have gone to the scene
        if ( change->value < RF_CHANGED_LAMP_VALUES && change->of == index && varies )
            return true;
    }
    return false;
}

bool rf_gltf_primitive_changes( const RfGltf* gltf, const RfField* primitive )
{
    int material = -1;
    return rf_gltf_has_changing( gltf ) && rf_gltf_material_of( gltf, primitive, &material ) == RF_OK && material >= 0 &&
           gltf->scene->materials[material].changes;
}

RfResult rf_gltf_note_frozen( RfGltf* gltf, const char* kind, const char* name )
{
    RfWhere what = rf_where( "%s '%.80s'", kind, name );
    return gltf->freeze ? rf_gltf_note_unrendered( gltf, what.text, "it changes" ) : RF_OK;
}

RfResult rf_gltf_add_lamp( RfGltf* gltf, const RfMovingLamp* lamp )
{
    if ( !rf_gltf_grow( &gltf->lamps, gltf->lamp_count, sizeof *gltf->lamps ) )
        return rf_gltf_no_memory( gltf, "lights" );
    gltf->lamps[gltf->lamp_count++] = *lamp;
    return RF_OK;
}

// Materials.

static bool is_of_texture( RfChangedValue value ) { return rf_changed_traits( value )->owner == RF_OF_TEXTURE; }

static bool is_emission( RfChangedValue value ) { return value == RF_CHANGED_EMISSIVE || value == RF_CHANGED_EMISSIVE_STRENGTH; }

// Whether a material that is read looks another way by a change of this.
static bool has_effect( const RfMaterial* m, const RfChange* change )
{
    const RfTextured* t = m->textured;
    if ( is_of_texture( change->value ) )
        return t->refs[change->slot].texture >= 0;
    if ( is_emission( change->value ) )
        return t->model != RF_TEXTURED_UNLIT;
    if ( change->value == RF_CHANGED_BASE_COLOR )
        return t->model != RF_TEXTURED_DIFFUSE || t->masked || t->blended;
    return t->model == RF_TEXTURED_COATED || t->model == RF_TEXTURED_GLASS;
}

// The transforms of textures, which are the material's unless they change.
static void follow_transforms( const RfGltf* gltf, RfMovingMaterial* moving, const RfMaterial* out )
{
    for ( int i = 0; i < moving->change_count; ++i )
    {
        const RfChange* change = gltf->changes + moving->first_change + i;
        if ( !is_of_texture( change->value ) || !has_effect( out, change ) )
            continue;
        double* transform = moving->transform[change->slot];
        rf_gltf_find_change( gltf, change->value, change->of, change->slot, rf_value_in( transform, change->value ) );
        rf_set_uv_transform( transform, out->textured->refs[change->slot].transform );
    }
}

static float most( float a, float b ) { return a > b ? a : b; }

static RfVec3 most_of( RfVec3 a, RfVec3 b ) { return rf_vec3( most( a.x, b.x ), most( a.y, b.y ), most( a.z, b.z ) ); }

// As light as it ever is, and both metal and not: what is asked of it while a scene is prepared holds at all times.
static void make_lightest( const RfGltf* gltf, const RfMovingMaterial* moving, RfMaterial* out )
{
    RfFactors* factors = &out->textured->factors;
    double base[4], unused[4];
    int color = rf_gltf_find_change( gltf, RF_CHANGED_BASE_COLOR, moving->material, 0, unused );
    if ( color >= 0 )
    {
        rf_most_of_change( gltf->changes + color, base );
        size_t first = out->textured->model == RF_TEXTURED_DIFFUSE ? 3 : 0; // which has a base of its own
        memcpy( factors->base + first, base + first, ( 4 - first ) * sizeof *base );
    }
    rf_derive_material( out );
    if ( rf_gltf_find_change( gltf, RF_CHANGED_METALLIC, moving->material, 0, unused ) < 0 )
        return;
    RfMaterial metal = *out;
    factors->metallic = 1.0;
    rf_derive_material( &metal );
    factors->metallic = 0.0;
    rf_derive_material( out );
    factors->metallic = moving->values.lobes.metallic;
    out->diffuse = most_of( out->diffuse, metal.diffuse );
    out->specular = most_of( out->specular, metal.specular );
    out->tint = most_of( out->tint, metal.tint );
    out->f90 = most( out->f90, metal.f90 );
    out->coat_f0 = most( out->coat_f0, metal.coat_f0 );
    out->coat_f90 = most( out->coat_f90, metal.coat_f90 );
}

// Notes what changes. Returns whether anything does.
static bool follow_changes( RfGltf* gltf, const RfMovingMaterial* moving, RfMaterial* out )
{
    RfTextured* t = out->textured;
    for ( int i = 0; i < moving->change_count; ++i )
    {
        const RfChange* change = gltf->changes + moving->first_change + i;
        bool varies = rf_channel_varies( &change->channel ) && has_effect( out, change );
        if ( !varies )
            continue;
        gltf->change_used[moving->first_change + i] = true;
        bool shapes = change->value == RF_CHANGED_METALLIC || change->value == RF_CHANGED_ROUGHNESS,
             of_normals = change->slot == RF_TEXTURE_NORMAL || change->slot == RF_TEXTURE_CLEARCOAT_NORMAL,
             turned = change->value == RF_CHANGED_TEXTURE_ROTATION || change->value == RF_CHANGED_TEXTURE_SCALE;
        out->dims = out->dims || is_emission( change->value );
        out->changes = out->changes || !is_emission( change->value );
        t->reshapes = t->reshapes || shapes;
        t->turns = t->turns || ( of_normals && turned );
    }
    return out->dims || out->changes;
}

RfResult rf_gltf_add_moving_material( RfGltf* gltf, const RfMovingMaterial* moving )
{
    if ( !rf_gltf_grow( &gltf->moving_materials, gltf->moving_material_count, sizeof *gltf->moving_materials ) )
        return rf_gltf_no_memory( gltf, "materials" );
    gltf->moving_materials[gltf->moving_material_count++] = *moving;
    return RF_OK;
}

RfResult rf_gltf_change_material( RfGltf* gltf, RfMovingMaterial* moving, RfMaterial* out )
{
    int first = lower_bound( gltf, RF_CHANGED_BASE_COLOR, moving->material, 0 ), end = first;
    while ( end < gltf->change_count && gltf->changes[end].of == moving->material &&
            group_of( gltf->changes[end].value ) == (int)RF_OF_MATERIAL )
        ++end;
    moving->first_change = first;
    moving->change_count = end - first;
    if ( first == end )
        return RF_OK;
    follow_transforms( gltf, moving, out );
    if ( !follow_changes( gltf, moving, out ) )
        return RF_OK;
    if ( gltf->freeze )
    {
        out->dims = out->changes = out->textured->reshapes = out->textured->turns = false;
        return rf_gltf_note_frozen( gltf, "material", out->name );
    }
    if ( out->changes )
    {
        out->textured->optional = false;
        make_lightest( gltf, moving, out );
    }
    return rf_gltf_add_moving_material( gltf, moving );
}

// A lamp's changes that the movement does not have yet.
static void move_lamp( const int* moved, RfMovingLamp* lamp, RfMovement* movement )
{
    for ( int v = 0; v < RF_CHANGED_LAMP_VALUES; ++v )
    {
        int change = lamp->changes[v];
        if ( change < 0 )
            continue;
        lamp->changes[v] = moved[change];
        RfChange* own = movement->changes + moved[change];
        own->of = own->of < 0 ? lamp->punctual : own->of;
    }
    movement->lamps[movement->lamp_count++] = *lamp;
}

// Marks the changes of lamps, and those with an effect of materials that are in use; copies of a material share them.
static void mark_used( RfGltf* gltf, const bool* used, int* marked )
{
    int kept = 0;
    for ( int i = 0; i < gltf->lamp_count; ++i )
    {
        for ( int v = 0; v < RF_CHANGED_LAMP_VALUES; ++v )
        {
            if ( gltf->lamps[i].changes[v] >= 0 )
                marked[gltf->lamps[i].changes[v]] = 1;
        }
    }
    for ( int i = 0; i < gltf->moving_material_count; ++i )
    {
        const RfMovingMaterial* self = gltf->moving_materials + i;
        bool keep = used[self->material];
        for ( int c = self->first_change; keep && c < self->first_change + self->change_count; ++c )
            marked[c] = gltf->change_used[c];
        if ( keep )
            gltf->moving_materials[kept++] = *self;
    }
    gltf->moving_material_count = kept;
}

// Moves the changes that are marked, and gives each its number in the movement.
static void move_list( RfGltf* gltf, RfMovement* movement, int* moved )
{
    for ( int i = 0; i < gltf->change_count; ++i )
    {
        gltf->change_used[i] = moved[i] != 0;
        moved[i] = movement->change_count;
        if ( !gltf->change_used[i] )
            continue;
        RfChange* to = movement->changes + movement->change_count++;
        *to = gltf->changes[i];
        if ( group_of( to->value ) == (int)RF_OF_LAMP )
            to->of = -1; // until a lamp has it
        memset( &gltf->changes[i].channel, 0, sizeof gltf->changes[i].channel );
    }
}

// Those of a material that are in use come one after the other.
static void move_material( const RfGltf* gltf, const int* moved, const RfMovingMaterial* from, RfMovement* movement )
{
    RfMovingMaterial* to = movement->materials + movement->material_count++;
    *to = *from;
    to->first_change = moved[from->first_change];
    to->change_count = 0;
    for ( int c = 0; c < from->change_count; ++c )
        to->change_count += gltf->change_used[from->first_change + c];
}

RfResult rf_gltf_move_changes( RfGltf* gltf, RfMovement* movement )
{
    size_t changes = (size_t)gltf->change_count + 1;
    bool* used = calloc( (size_t)gltf->scene->material_count + 1, sizeof *used );
    int* moved = calloc( changes, sizeof *moved );
    bool room = rf_make_room( &movement->changes, (size_t)movement->change_count + changes, sizeof *movement->changes );
    movement->lamps = calloc( (size_t)gltf->lamp_count + 1, sizeof *movement->lamps );
    movement->materials = calloc( (size_t)gltf->moving_material_count + 1, sizeof *movement->materials );
    room = room && used != NULL && moved != NULL && movement->lamps != NULL && movement->materials != NULL;
    if ( room )
    {
        rf_mark_used_materials( gltf->scene, used );
        mark_used( gltf, used, moved );
        move_list( gltf, movement, moved );
    }
    for ( int i = 0; room && i < gltf->lamp_count; ++i )
        move_lamp( moved, gltf->lamps + i, movement );
    for ( int i = 0; room && i < gltf->moving_material_count; ++i )
        move_material( gltf, moved, gltf->moving_materials + i, movement );
    free( used );
    free( moved );
    return room ? RF_OK : rf_gltf_no_memory( gltf, "animations" );
}
