#include "render/frame_queue.h"

#include "trace/trace.h"

// Calls the caller with the oldest buffer, unless a frame before it failed.
static void hand_over( RfFrameQueue* d, const RfFrameBuffer* buffer )
{
    if ( d->callbacks->frame == NULL || d->result != RF_OK )
        return;
    RfError error = { .code = RF_OK };
    RfResult result = d->callbacks->frame( d->callbacks->user, &buffer->result, &error );
    if ( result == RF_OK )
        return;
    if ( d->threaded )
        pthread_mutex_lock( &d->mutex );
    d->result = result;
    d->error = error;
    if ( d->threaded )
        pthread_mutex_unlock( &d->mutex );
}

static void* run( void* user )
{
    RfFrameQueue* d = user;
    rf_set_float_mode(); // what the caller computes is not to depend on the thread
    pthread_mutex_lock( &d->mutex );
    for ( ;; )
    {
        while ( d->waiting == 0 && !d->ended )
            pthread_cond_wait( &d->changed, &d->mutex );
        if ( d->waiting == 0 )
            break;
        RfFrameBuffer* buffer = d->buffers + d->first;
        pthread_mutex_unlock( &d->mutex );
        hand_over( d, buffer );
        pthread_mutex_lock( &d->mutex );
        d->first = ( d->first + 1 ) % d->buffer_count;
        d->waiting -= 1;
        pthread_cond_broadcast( &d->changed );
    }
    pthread_mutex_unlock( &d->mutex );
    return NULL;
}

static bool start_thread( RfFrameQueue* d )
{
    if ( pthread_mutex_init( &d->mutex, NULL ) != 0 )
        return false;
    if ( pthread_cond_init( &d->changed, NULL ) == 0 )
    {
        d->threaded = true; // before the thread looks at it
        if ( pthread_create( &d->thread, NULL, run, d ) == 0 )
            return true;
        d->threaded = false;
        pthread_cond_destroy( &d->changed );
    }
    pthread_mutex_destroy( &d->mutex );
    return false;
}

void rf_start_frame_queue( RfFrameQueue* delivery, const RfRenderCallbacks* callbacks, RfFrameBuffer* buffers, int count,
                           bool threaded )
{
    *delivery = ( RfFrameQueue ){ .callbacks = callbacks, .buffers = buffers, .buffer_count = count };
    if ( threaded )
        start_thread( delivery );
}

RfFrameBuffer* rf_next_frame_buffer( RfFrameQueue* d )
{
    if ( !d->threaded )
        return d->buffers;
    pthread_mutex_lock( &d->mutex );
    while ( d->waiting == d->buffer_count )
        pthread_cond_wait( &d->changed, &d->mutex );
    RfFrameBuffer* buffer = d->buffers + ( d->first + d->waiting ) % d->buffer_count;
    pthread_mutex_unlock( &d->mutex );
    return buffer;
}

void rf_queue_frame( RfFrameQueue* d )
{
    if ( !d->threaded )
    {
        hand_over( d, d->buffers );
        return;
    }
    pthread_mutex_lock( &d->mutex );
    d->waiting += 1;
    pthread_cond_broadcast( &d->changed );
    pthread_mutex_unlock( &d->mutex );
}

static RfResult failure( const RfFrameQueue* d, RfError* error )
{
    if ( d->result != RF_OK && error != NULL )
        *error = d->error;
    return d->result;
}

RfResult rf_check_frame_queue( RfFrameQueue* d, RfError* error )
{
    if ( !d->threaded )
        return failure( d, error );
    pthread_mutex_lock( &d->mutex );
    RfResult result = failure( d, error );
    pthread_mutex_unlock( &d->mutex );
    return result;
}

RfResult rf_end_frame_queue( RfFrameQueue* d, RfError* error )
{
    if ( d->threaded )
    {
        pthread_mutex_lock( &d->mutex );
        d->ended = true;
        pthread_cond_broadcast( &d->changed );
        pthread_mutex_unlock( &d->mutex );
        pthread_join( d->thread, NULL );
        pthread_cond_destroy( &d->changed );
        pthread_mutex_destroy( &d->mutex );
        d->threaded = false;
    }
    return failure( d, error );
}
