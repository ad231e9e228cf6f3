// Converts models of other formats (OBJ, PLY, FBX, Collada) to .glb, which rf_open_scene reads.
//
//     RfConvertOptions options = rf_default_convert_options();
//     options.up = RF_UP_Z;
//     RfResult result = rf_convert_model( "bunny.ply", "bunny.glb", &options, NULL, &log, &error );
#ifndef REFRAME_CONVERT_H
#define REFRAME_CONVERT_H

#include "reframe/error.h"
#include "reframe/types.h"

RF_API_BEGIN

// Which axis of a model points up, and becomes glTF's y.
typedef enum RfUpAxis
{
    RF_UP_OF_FILE, // as the file says (FBX, Collada); y where it does not
    RF_UP_Y,
    RF_UP_Z
} RfUpAxis;

typedef struct RfConvertOptions
{
    RfUpAxis up;                            // FBX: in place of what the file says; Collada: after it
    double scale;                           // metres per unit of the model, after what its own units say
    bool overwrite;                         // a target that is there is replaced; else it is an error
    bool accept_losses;                     // textures that cannot be read are left out, with a warning; else they are an error
    bool assimp;                            // PLY too is read by assimp, not by the strict reader of ours
    const char* importer;                   // path of reframe-import, the process that assimp runs in; NULL: looked for beside
                                            // the running program, then in ../libexec/reframe and ../lib/reframe from there
    size_t memory;                          // bytes of address space that assimp may take before it is stopped
    double seconds;                         // that assimp may take before it is stopped
    bool ( *is_interrupted )( void* user ); // asked several times a second while assimp runs; or NULL
    void* user;
} RfConvertOptions;

// Up as the file says, scale 1, 4 GiB, 120 s.
RfConvertOptions rf_default_convert_options( void );

// What is in a model, instances counted once; `morphs` are morph targets.
typedef struct RfModelCounts
{
    unsigned long long triangles;
    int meshes, nodes, materials, images, cameras, lights, skins, morphs, animations;
} RfModelCounts;

// Reads `source`, whose format is recognised by its content, and writes `target`, which must end in ".glb", whole
// or not at all; its folder is made where it is missing. `counts` and `log` may be NULL. Fails with RF_ERROR_USAGE (a target of another
// name, a source that is glTF already), RF_ERROR_IO, RF_ERROR_FORMAT (also where assimp crashes on
// it or takes too long), RF_ERROR_UNSUPPORTED, RF_ERROR_MEMORY, RF_ERROR_INTERRUPTED.
RfResult rf_convert_model( const char* source, const char* target, const RfConvertOptions* options, RfModelCounts* counts,
                           RfLog* log, RfError* error );

RF_API_END

#endif
