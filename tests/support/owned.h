// Types of variables that are released at the end of their block, the last first. With json_auto_t* of Jansson:
//
//     AUTO_SCENE scene = make_room( ROOM_GGX );
//     AUTO_FREE char* text = cli_read( "a.txt", &size );
//     AUTO_BY( rf_destroy_exr_header ) RfExrHeader header;
#ifndef REFRAME_TESTS_OWNED_H
#define REFRAME_TESTS_OWNED_H

#define AUTO_BY( destroy ) __attribute__( ( cleanup( destroy ) ) )
#define AUTO_SCENE AUTO_BY( rf_destroy_scene ) RfScene
#define AUTO_POSE AUTO_BY( rf_destroy_pose ) RfPosedScene
#define AUTO_IMAGE AUTO_BY( rf_destroy_image ) RfImage
#define AUTO_CAMERA AUTO_BY( rf_destroy_camera ) RfCamera
#define AUTO_TRACER AUTO_BY( destroy_tracer_at ) RfTracer*
#define AUTO_FREE AUTO_BY( free_at )

// What the macros call.
void destroy_tracer_at( void* tracer );
void free_at( void* pointer );

#endif
