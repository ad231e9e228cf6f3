// A ring of finished frames between the render and a thread that hands them to the caller in order.
#include "render/frame_queue.h"

#include "trace/trace.h"

// Without a thread nothing is shared.
static void lock( RfFrameQueue* q )
{
    if ( q->threaded )
        pthread_mutex_lock( &q->mutex );
}

static void unlock( RfFrameQueue* q )
{
    if ( q->threaded )
        pthread_mutex_unlock( &q->mutex );
}

// Calls the caller with the oldest buffer, unless a frame before it failed.
static void hand_over( RfFrameQueue* q, const RfFrameBuffer* buffer )
{
    if ( q->callbacks->frame == NULL || q->result != RF_OK )
        return;
    RfError error = { .code = RF_OK };
    RfResult result = q->callbacks->frame( q->callbacks->user, &buffer->result, &error );
    if ( result == RF_OK )
        return;
    if ( error.code == RF_OK )
        rf_fail( &error, result, "frame %d was not taken by its callback, which does not say why", buffer->result.frame + 1 );
    lock( q );
    q->result = result;
    q->error = error;
    unlock( q );
}

static void* run( void* user )
{
    RfFrameQueue* q = user;
    rf_set_float_mode(); // the caller's arithmetic must not depend on the thread
    pthread_mutex_lock( &q->mutex );
    for ( ;; )
    {
        while ( q->waiting == 0 && !q->ended )
            pthread_cond_wait( &q->changed, &q->mutex );
        if ( q->waiting == 0 )
            break;
        RfFrameBuffer* buffer = q->buffers + q->first;
        pthread_mutex_unlock( &q->mutex );
        hand_over( q, buffer );
        pthread_mutex_lock( &q->mutex );
        q->first = ( q->first + 1 ) % q->buffer_count;
        q->waiting -= 1;
        pthread_cond_broadcast( &q->changed );
    }
    pthread_mutex_unlock( &q->mutex );
    return NULL;
}

static bool start_thread( RfFrameQueue* q )
{
    if ( pthread_mutex_init( &q->mutex, NULL ) != 0 )
        return false;
    if ( pthread_cond_init( &q->changed, NULL ) == 0 )
    {
        q->threaded = true; // set before the thread reads it
        if ( pthread_create( &q->thread, NULL, run, q ) == 0 )
            return true;
        q->threaded = false;
        pthread_cond_destroy( &q->changed );
    }
    pthread_mutex_destroy( &q->mutex );
    return false;
}

void rf_start_frame_queue( RfFrameQueue* queue, const RfRenderCallbacks* callbacks, RfFrameBuffer* buffers, int count,
                           bool threaded )
{
    *queue = ( RfFrameQueue ){ .callbacks = callbacks, .buffers = buffers, .buffer_count = count };
    if ( threaded )
        start_thread( queue );
}

// Without a thread none is ever waiting.
static RfFrameBuffer* next_of( const RfFrameQueue* q ) { return q->buffers + ( q->first + q->waiting ) % q->buffer_count; }

RfFrameBuffer* rf_next_frame_buffer( RfFrameQueue* q )
{
    lock( q );
    while ( q->waiting == q->buffer_count )
        pthread_cond_wait( &q->changed, &q->mutex );
    RfFrameBuffer* buffer = next_of( q );
    unlock( q );
    return buffer;
}

RfFrameBuffer* rf_free_frame_buffer( RfFrameQueue* q )
{
    lock( q );
    RfFrameBuffer* buffer = q->waiting < q->buffer_count ? next_of( q ) : NULL;
    unlock( q );
    return buffer;
}

void rf_queue_frame( RfFrameQueue* q )
{
    if ( !q->threaded )
    {
        hand_over( q, q->buffers );
        return;
    }
    lock( q );
    q->waiting += 1;
    pthread_cond_broadcast( &q->changed );
    unlock( q );
}

static RfResult failure( const RfFrameQueue* q, RfError* error )
{
    if ( q->result != RF_OK && error != NULL )
        *error = q->error;
    return q->result;
}

RfResult rf_check_frame_queue( RfFrameQueue* q, RfError* error )
{
    lock( q );
    RfResult result = failure( q, error );
    unlock( q );
    return result;
}

RfResult rf_drain_frame_queue( RfFrameQueue* q, RfError* error )
{
    lock( q );
    while ( q->waiting > 0 )
        pthread_cond_wait( &q->changed, &q->mutex );
    RfResult result = failure( q, error );
    unlock( q );
    return result;
}

RfResult rf_end_frame_queue( RfFrameQueue* q, RfError* error )
{
    if ( q->threaded )
    {
        pthread_mutex_lock( &q->mutex );
        q->ended = true;
        pthread_cond_broadcast( &q->changed );
        pthread_mutex_unlock( &q->mutex );
        pthread_join( q->thread, NULL );
        pthread_cond_destroy( &q->changed );
        pthread_mutex_destroy( &q->mutex );
        q->threaded = false;
    }
    return failure( q, error );
}
