// Queue of finished frames. A thread of its own hands them to the caller in order, so that
// rendering goes on while the caller encodes and writes them. The images wait in a
// ring of buffers that is allocated once; when all are full, rendering waits. Without a thread the
// caller is called by the render itself.
#ifndef REFRAME_RENDER_FRAME_QUEUE_H
#define REFRAME_RENDER_FRAME_QUEUE_H

#include "film/cryptomatte.h"
#include "reframe/render.h"
#include "scene/light_groups.h"

#include <pthread.h>

// The images of one finished frame, allocated by the render.
typedef struct RfFrameBuffer
{
    float* rgb;
    float* weight;
    float* layers[RF_AOV_COUNT];                                 // those asked for
    float* mattes[RF_CRYPTOMATTE_KINDS * RF_CRYPTOMATTE_LAYERS]; // likewise
    float* groups[RF_LIGHT_GROUPS_MOST];                         // of light groups, 3 per pixel
    RfLayer* list;                                               // of the frame; NULL: it has none
    RfFrameResult result;                                        // points into them
} RfFrameBuffer;

typedef struct RfFrameQueue
{
    const RfRenderCallbacks* callbacks;
    RfFrameBuffer* buffers; // a ring: frames go round in it
    int buffer_count;
    bool threaded;
    pthread_t thread;
    pthread_mutex_t mutex; // of all below
    pthread_cond_t changed;
    int first, waiting; // buffers [first, first + waiting) of the ring are handed over or being so
    bool ended;         // no more will come
    RfResult result;    // first failure of the caller; no frame is handed over after it
    RfError error;
} RfFrameQueue;

// Starts with `count` ≥ 1 buffers; with `threaded` a thread is started, where
// the system has one.
void rf_start_frame_queue( RfFrameQueue* queue, const RfRenderCallbacks* callbacks, RfFrameBuffer* buffers, int count,
                           bool threaded );

// A buffer that is free; waits until there is one.
RfFrameBuffer* rf_next_frame_buffer( RfFrameQueue* queue );

// The same without waiting; NULL where there is none.
RfFrameBuffer* rf_free_frame_buffer( RfFrameQueue* queue );

// Queues the buffer of rf_next_frame_buffer, now filled. The render must not touch it any more.
void rf_queue_frame( RfFrameQueue* queue );

// The caller's failure so far, or RF_OK. Calls from the render's thread.
RfResult rf_check_frame_queue( RfFrameQueue* queue, RfError* error );

// Waits until all frames so far are handed over; returns the caller's failure or RF_OK.
RfResult rf_drain_frame_queue( RfFrameQueue* queue, RfError* error );

// Waits until all frames are handed over, ends the thread, and returns the
// caller's failure or RF_OK.
RfResult rf_end_frame_queue( RfFrameQueue* queue, RfError* error );

#endif
