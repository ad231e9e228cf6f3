// Materials of assimp's scene, and their images.
#include "import/assimp_import.h"

#include "base/file.h"
#include "base/words.h"

#include <assimp/ObjMaterial.h>
#include <assimp/material.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define IMAGE_LIMIT ( 1ull << 30 )

static const char* mime_of( const uint8_t* bytes, size_t size )
{
    static const uint8_t png[8] = { 0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n' };
    if ( size > sizeof png && memcmp( bytes, png, sizeof png ) == 0 )
        return "image/png";
    return size > 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff ? "image/jpeg" : NULL;
}

static const char* file_name_of( const char* name )
{
    const char* slash = strrchr( name, '/' );
    return slash != NULL ? slash + 1 : name;
}

// Reads an embedded image: "*3", or by its original name.
static bool read_embedded( RfImport* import, const char* name, uint8_t** bytes, size_t* size )
{
    const struct aiScene* scene = import->scene;
    for ( unsigned i = 0; i < scene->mNumTextures; ++i )
    {
        const struct aiTexture* texture = scene->mTextures[i];
        char star[16], own[1024];
        snprintf( star, sizeof star, "*%u", i );
        snprintf( own, sizeof own, "%s", texture->mFilename.data );
        for ( char* c = own; *c != 0; ++c )
            *c = *c == '\\' ? '/' : *c;
        if ( texture->mHeight != 0 || texture->mWidth == 0 ||
             ( strcmp( name, star ) != 0 && strcmp( file_name_of( name ), file_name_of( own ) ) != 0 ) )
            continue;
        *size = texture->mWidth;
        *bytes = malloc( *size );
        if ( *bytes != NULL )
            memcpy( *bytes, texture->pcData, *size );
        return *bytes != NULL;
    }
    return false;
}

// Reads an image by its name, relative to the folder of the file; else, as paths often belong
// to the machine on which the file was made, by its last component beside the file.
static bool read_beside( RfImport* import, const char* name, uint8_t** bytes, size_t* size )
{
    char path[8192];
    int folder = (int)( file_name_of( import->source->path ) - import->source->path );
    snprintf( path, sizeof path, "%.*s%s", *name == '/' ? 0 : folder, import->source->path, name );
    if ( rf_read_file( path, IMAGE_LIMIT, bytes, size, NULL ) == RF_OK )
        return true;
    snprintf( path, sizeof path, "%.*s%s", folder, import->source->path, file_name_of( name ) );
    return rf_read_file( path, IMAGE_LIMIT, bytes, size, NULL ) == RF_OK;
}

static bool make_room( RfImport* import )
{
    RfModel* model = import->model;
    if ( model->image_count < import->image_room )
        return true;
    int room = import->image_room > 0 ? 2 * import->image_room : 16;
    RfModelImage* images = realloc( model->images, (size_t)room * sizeof *images );
    if ( images == NULL )
        return false;
    model->images = images;
    char( *names )[1024] = realloc( import->image_names, (size_t)room * sizeof *names );
    if ( names == NULL )
        return false;
    import->image_names = names;
    import->image_room = room;
    return true;
}

static int lose_image( RfImport* import, const char* name, const char* why )
{
    char text[1200];
    snprintf( text, sizeof text, "texture '%s': %s", name, why );
    if ( strstr( import->lost, text ) != NULL )
        return -1;
    if ( import->accepts_losses )
        rf_warn( import->log, "%s: it is left out", text );
    rf_append( import->lost, sizeof import->lost, "%s%s", import->lost[0] != 0 ? "; " : "", text );
    return -1;
}

// The index of the image that a texture names (a path, or "*0" for an embedded one), read on
// first use; −1 if it cannot be read.
static int import_image( RfImport* import, const char* given )
{
    RfModel* model = import->model;
    char name[1024];
    snprintf( name, sizeof name, "%s", given );
    for ( char* c = name; *c != 0; ++c )
        *c = *c == '\\' ? '/' : *c;
    for ( int i = 0; i < model->image_count; ++i )
    {
        if ( strcmp( import->image_names[i], name ) == 0 )
            return i;
    }
    uint8_t* bytes = NULL;
    size_t size = 0;
    if ( !read_embedded( import, name, &bytes, &size ) && !read_beside( import, name, &bytes, &size ) )
        return lose_image( import, name, "cannot be read, put it beside the file" );
    const char* mime = mime_of( bytes, size );
    if ( mime == NULL || !make_room( import ) )
    {
        free( bytes );
        return mime != NULL ? -1 : lose_image( import, name, "is neither PNG nor JPEG, convert it and rename it" );
    }
    snprintf( import->image_names[model->image_count], sizeof name, "%s", name );
    model->images[model->image_count] =
        ( RfModelImage ){ .name = strdup( file_name_of( name ) ), .mime = mime, .bytes = bytes, .size = size };
    return model->image_count++;
}

// Converts materials of other formats to glTF's. Most are Phong: a diffuse colour, a specular
// colour and an exponent.

typedef struct RfPhong
{
    float diffuse[3], specular[3], emission[3], filter[3];
    float exponent, opacity, ior;
    bool has_specular;
    int illumination; // OBJ's "illum", −1 for other formats
} RfPhong;

static bool get_color( const struct aiMaterial* from, const char* key, float* out )
{
    struct aiColor4D c;
    if ( aiGetMaterialColor( from, key, 0, 0, &c ) != aiReturn_SUCCESS )
        return false;
    out[0] = c.r;
    out[1] = c.g;
    out[2] = c.b;
    return true;
}

static float get_float( const struct aiMaterial* from, const char* key, float otherwise )
{
    float value;
    bool is_there = aiGetMaterialFloatArray( from, key, 0, 0, &value, NULL ) == aiReturn_SUCCESS;
    return is_there && isfinite( value ) ? value : otherwise;
}

static int get_int( const struct aiMaterial* from, const char* key, int otherwise )
{
    int value;
    return aiGetMaterialIntegerArray( from, key, 0, 0, &value, NULL ) == aiReturn_SUCCESS ? value : otherwise;
}

static RfPhong read_phong( const RfImport* import, const struct aiMaterial* from )
{
    RfPhong p = { .diffuse = { 0.8f, 0.8f, 0.8f }, .filter = { 1, 1, 1 }, .illumination = -1 };
    get_color( from, "$clr.diffuse", p.diffuse );
    get_color( from, "$clr.base", p.diffuse );
    p.has_specular = get_color( from, "$clr.specular", p.specular );
    get_color( from, "$clr.emissive", p.emission );
    get_color( from, "$clr.transparent", p.filter );
    p.exponent = get_float( from, "$mat.shininess", 0 );
    p.opacity = get_float( from, "$mat.opacity", 1 );
    p.ior = get_float( from, "$mat.refracti", 1 );
    float strength = get_float( from, "$mat.emissiveIntensity", 1 );
    for ( int i = 0; i < 3; ++i )
        p.emission[i] = p.emission[i] * strength > 0.0f && isfinite( p.emission[i] * strength ) ? p.emission[i] * strength : 0.0f;
    if ( import->source->format == RF_SOURCE_OBJ )
        p.illumination = get_int( from, "$mat.illum", -1 );
    return p;
}

static float largest( const float* color ) { return fmaxf( color[0], fmaxf( color[1], color[2] ) ); }

// A Phong lobe cosⁿ is about as wide as a GGX lobe of alpha = √(2 / (n + 2)), and glTF's
// roughness is √alpha. Without a specular colour the material is not glossy. A specular colour
// of 0.5 means the 4 % of plastic and glass, as exporters write it; a bright one over a black
// diffuse colour means a metal.
static void set_surface( RfModelMaterial* m, const RfPhong* p )
{
    float shine = rf_clamp01( largest( p->specular ) );
    m->roughness = rf_clamp01( powf( 2.0f / ( fmaxf( p->exponent, 0.0f ) + 2.0f ), 0.25f ) );
    m->specular = rf_clamp01( 2.0f * shine );
    m->metallic = 0.0f;
    const float* base = p->diffuse;
    if ( shine == 0.0f )
        m->roughness = 1.0f;
    else if ( shine >= 0.25f && largest( p->diffuse ) <= 0.0f )
    {
        base = p->specular;
        m->metallic = 1.0f;
        m->specular = 1.0f;
    }
    for ( int i = 0; i < 3; ++i )
        m->base_color[i] = rf_clamp01( base[i] );
}

// OBJ's illumination models 4, 6, 7 and 9 are glass, tinted by Tf.
static bool set_glass( RfModelMaterial* m, const RfPhong* p )
{
    int i = p->illumination;
    if ( i != 4 && i != 6 && i != 7 && i != 9 )
        return false;
    m->transmission = 1.0f;
    m->metallic = m->roughness = 0.0f;
    m->specular = 1.0f;
    for ( int k = 0; k < 3; ++k )
        m->base_color[k] = rf_clamp01( p->filter[k] );
    return true;
}

static void set_opacity( RfImport* import, RfModelMaterial* m, const RfPhong* p )
{
    float opacity = rf_clamp01( p->opacity );
    if ( opacity == 0.0f )
    {
        // exporters disagree on which end is transparent, and invisible materials are not intended
        rf_warn( import->log, "material '%s': has opacity 0: it is taken as opaque", m->name != NULL ? m->name : "" );
        opacity = 1.0f;
    }
    m->base_color[3] = opacity;
    if ( opacity < 1.0f )
        m->alpha_mode = RF_MODEL_BLEND;
}

// Parameters of physically based materials (MTL's Pr and Pm, newer FBX) take precedence over
// those derived from Phong's.
static void set_physical( RfModelMaterial* m, const struct aiMaterial* from, bool obj )
{
    float roughness = get_float( from, "$mat.roughnessFactor", -1 ), metallic = get_float( from, "$mat.metallicFactor", -1 );
    // assimp returns zeros for an MTL without them
    bool given = !obj || roughness > 0.0f || metallic > 0.0f;
    if ( given && ( roughness >= 0.0f || metallic >= 0.0f ) )
        m->specular = 1.0f;
    if ( given && roughness >= 0.0f )
        m->roughness = rf_clamp01( roughness );
    if ( given && metallic >= 0.0f )
        m->metallic = rf_clamp01( metallic );
}

// Whether Blender wrote the file, whose reflectivity is how metallic a material is.
static bool is_by_blender( const RfImport* import )
{
    const struct aiMetadata* data = import->scene->mMetaData;
    for ( unsigned i = 0; data != NULL && i < data->mNumProperties; ++i )
    {
        const struct aiMetadataEntry* entry = data->mValues + i;
        if ( entry->mType == AI_AISTRING && entry->mData != NULL && strcmp( data->mKeys[i].data, "SourceAsset_Generator" ) == 0 )
            return strncmp( ( (const struct aiString*)entry->mData )->data, "Blender", 7 ) == 0;
    }
    return import->source->binds_at_rest;
}

// Reflectivity of FBX and Collada, which has no place in glTF unless it means metal.
static void set_reflection( const RfImport* import, RfModelMaterial* m, const struct aiMaterial* from )
{
    float color[3] = { 0, 0, 0 }, amount = get_float( from, "$mat.reflectivity", 0 );
    if ( amount <= 0.0f || ( import->source->format != RF_SOURCE_FBX && import->source->format != RF_SOURCE_COLLADA ) )
        return;
    if ( is_by_blender( import ) )
        m->metallic = rf_clamp01( amount );
    else if ( get_color( from, "$clr.reflective", color ) && largest( color ) > 0.0f && m->metallic == 0.0f )
        rf_warn( import->log, "material '%s': its reflection of %.3g is left out: give it a metallic factor",
                 m->name != NULL ? m->name : "", (double)( amount * largest( color ) ) );
}

// The file name of the first texture of a kind; false if there is none.
static bool get_texture( const struct aiMaterial* from, enum aiTextureType type, struct aiString* name )
{
    return aiGetMaterialTextureCount( from, type ) > 0 &&
           aiGetMaterialTexture( from, type, 0, name, NULL, NULL, NULL, NULL, NULL, NULL ) == aiReturn_SUCCESS &&
           name->length > 0;
}

// Names what of the placement of a texture is left out.
static void name_placement( const RfImport* import, const struct aiMaterial* from, enum aiTextureType type, const char* material )
{
    struct aiUVTransform t = { .mScaling = { 1, 1 } };
    int channel = 0;
    bool moved = aiGetMaterialUVTransform( from, "$tex.uvtrafo", (unsigned)type, 0, &t ) == aiReturn_SUCCESS &&
                 ( t.mScaling.x != 1.0f || t.mScaling.y != 1.0f || t.mTranslation.x != 0.0f || t.mTranslation.y != 0.0f ||
                   t.mRotation != 0.0f );
    if ( moved )
        rf_warn( import->log,
                 "material '%s': its texture is scaled by %.4g %.4g, moved by %.4g %.4g and turned in the file: this is left out",
                 material, (double)t.mScaling.x, (double)t.mScaling.y, (double)t.mTranslation.x, (double)t.mTranslation.y );
    if ( aiGetMaterialIntegerArray( from, "$tex.uvwsrc", (unsigned)type, 0, &channel, NULL ) == aiReturn_SUCCESS && channel > 0 )
        rf_warn( import->log, "material '%s': its texture is at the coordinates of set %d: it is put at the first", material,
                 channel + 1 );
}

// The texture of a kind; `slot` is that of RF_FACT_MAP.
static RfModelTexture take_texture( RfImport* import, const struct aiMaterial* from, enum aiTextureType type,
                                    const char* material, int slot )
{
    struct aiString name;
    RfModelTexture texture = { .image = get_texture( from, type, &name ) ? import_image( import, name.data ) : -1 };
    if ( texture.image < 0 )
        return texture;
    const RfFact* map = rf_find_fact( import->source, RF_FACT_MAP, material, slot );
    if ( map != NULL )
    {
        for ( int i = 0; i < 2; ++i )
            texture.scale[i] = (float)map->values[i];
        texture.offset[0] = (float)map->values[2];
        texture.offset[1] = (float)( 1.0 - map->values[1] - map->values[3] ); // v points down in glTF
        texture.clamp = map->values[4] != 0.0;
    }
    else if ( import->source->format != RF_SOURCE_OBJ )
        name_placement( import, from, type, material );
    return texture;
}

static void set_textures( RfImport* import, RfModelMaterial* m, const struct aiMaterial* from )
{
    struct aiString name, opacity;
    const char* called = m->name != NULL ? m->name : "";
    m->base_color_texture = take_texture( import, from, aiTextureType_DIFFUSE, called, 0 );
    if ( m->base_color_texture.image < 0 )
        m->base_color_texture = take_texture( import, from, aiTextureType_BASE_COLOR, called, 0 );
    m->normal_texture = take_texture( import, from, aiTextureType_NORMALS, called, 1 );
    m->emissive_texture = take_texture( import, from, aiTextureType_EMISSIVE, called, 2 );
    if ( m->emissive_texture.image >= 0 && largest( m->emission ) == 0.0f )
        m->emission[0] = m->emission[1] = m->emission[2] = 1.0f;
    if ( get_texture( from, aiTextureType_OPACITY, &opacity ) )
    {
        bool same = get_texture( from, aiTextureType_DIFFUSE, &name ) && strcmp( name.data, opacity.data ) == 0;
        if ( same && m->base_color_texture.image >= 0 )
            m->alpha_mode = RF_MODEL_BLEND; // the alpha channel of the colour texture
        else
            rf_warn( import->log, "material '%s': its opacity texture is left out: put it into the colour's alpha", called );
    }
    if ( get_texture( from, aiTextureType_HEIGHT, &name ) )
        rf_warn( import->log, "material '%s': its bump map is left out: only normal maps are taken", called );
    if ( get_texture( from, aiTextureType_SPECULAR, &name ) || get_texture( from, aiTextureType_SHININESS, &name ) )
        rf_warn( import->log, "material '%s': its specular textures are left out", called );
}

static void take_material( RfImport* import, const struct aiMaterial* from, RfModelMaterial* m )
{
    struct aiString name;
    *m = rf_default_model_material();
    if ( aiGetMaterialString( from, AI_MATKEY_NAME, &name ) == aiReturn_SUCCESS )
        m->name = rf_import_text( &name );
    RfPhong p = read_phong( import, from );
    set_surface( m, &p );
    if ( set_glass( m, &p ) )
        p.opacity = 1.0f;
    set_opacity( import, m, &p );
    set_physical( m, from, import->source->format == RF_SOURCE_OBJ );
    set_reflection( import, m, from );
    memcpy( m->emission, p.emission, sizeof m->emission );
    if ( p.ior > 1.0f && p.ior < 10.0f )
        m->ior = p.ior;
    set_textures( import, m, from );
    // These formats do not define sidedness: surfaces are double-sided, but emitters emit from the
    // front only.
    m->double_sided = largest( m->emission ) == 0.0f || get_int( from, "$mat.twosided", 0 ) != 0;
    m->double_sided = m->double_sided && m->transmission == 0.0f;
}

RfResult rf_import_materials( RfImport* import, RfError* error )
{
    const struct aiScene* scene = import->scene;
    RfModel* model = import->model;
    model->materials = calloc( (size_t)scene->mNumMaterials + 1, sizeof *model->materials );
    if ( model->materials == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY );
    for ( unsigned i = 0; i < scene->mNumMaterials; ++i )
        take_material( import, scene->mMaterials[i], model->materials + model->material_count++ );
    return RF_OK;
}
