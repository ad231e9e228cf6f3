// Meshes decoded by libdraco, behind functions of C.
#ifndef REFRAME_GLTF_DRACO_MESH_H
#define REFRAME_GLTF_DRACO_MESH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C"
{
#endif

    typedef struct RfDracoMesh RfDracoMesh;

    // What became of a mesh.
    typedef enum RfDracoResult
    {
        RF_DRACO_OK,
        RF_DRACO_BROKEN,
        RF_DRACO_NO_MESH,   // a cloud of points
        RF_DRACO_TOO_LARGE, // beyond the limits: few bytes may say that there are billions of triangles
        RF_DRACO_MEMORY,
    } RfDracoResult;

    // Decodes a mesh of up to `most_faces` triangles, whose attributes take up to `most_bytes`. Both are compared before memory is
    // spent on them. The caller frees the mesh.
    RfDracoResult rf_draco_decode( const uint8_t* bytes, size_t size, uint64_t most_faces, uint64_t most_bytes,
                                   RfDracoMesh** mesh );

    // Frees a mesh, or NULL.
    void rf_draco_free( RfDracoMesh* mesh );

    uint32_t rf_draco_faces( const RfDracoMesh* mesh );
    uint32_t rf_draco_points( const RfDracoMesh* mesh );
    int rf_draco_attributes( const RfDracoMesh* mesh );

    // What it takes of memory: its faces, and the values of its attributes with their maps.
    uint64_t rf_draco_bytes( const RfDracoMesh* mesh );

    // The attribute with this unique id, −1 if there is none.
    int rf_draco_find( const RfDracoMesh* mesh, uint32_t unique_id );

    // Numbers per point, 1 to 255.
    int rf_draco_components( const RfDracoMesh* mesh, int attribute );

    // Copies three indices per triangle.
    void rf_draco_copy_indices( const RfDracoMesh* mesh, uint32_t* indices );

    // Copies the values of all points, packed, as a component type of glTF (5120 to 5126). False if one cannot be represented in it.
    bool rf_draco_copy( const RfDracoMesh* mesh, int attribute, int component_type, uint8_t* values );

#ifdef __cplusplus
}
#endif

#endif
