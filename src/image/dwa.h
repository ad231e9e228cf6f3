// DWA by OpenEXR's C++ library, of a block of lines: OpenEXRCore has it since 3.1.8 only, and always takes channels for colours
// by their names.
#ifndef REFRAME_IMAGE_DWA_H
#define REFRAME_IMAGE_DWA_H

#include <stddef.h>

#ifdef __cplusplus
extern "C"
{
#endif

    // A channel, in the order of the names.
    typedef struct RfDwaChannel
    {
        const char* name;
        int type;   // exr_pixel_type_t
        int linear; // the channel's pLinear
        int exact;  // when compressing: kept bit by bit, whatever its name
    } RfDwaChannel;

    // A block as OpenEXR packs it: line by line, in a line channel by channel.
    typedef struct RfDwaBlock
    {
        const RfDwaChannel* channels;
        int count;
        int width, height;
        float level; // when compressing
    } RfDwaBlock;

    typedef enum RfDwaResult
    {
        RF_DWA_OK,
        RF_DWA_MEMORY,
        RF_DWA_BROKEN, // with a message
    } RfDwaResult;

#define RF_DWA_MESSAGE_SIZE 256

    // Compresses the `size` bytes of a block into as many at most; *compressed is their number, `size` where they would not get
    // fewer, and then they are those of the block.
    RfDwaResult rf_compress_dwa( const RfDwaBlock* block, const void* packed, size_t size, void* out, size_t* compressed,
                                 char message[RF_DWA_MESSAGE_SIZE] );

    // The other way round, into the `size` bytes of the block.
    RfDwaResult rf_decompress_dwa( const RfDwaBlock* block, const void* compressed, size_t compressed_size, void* out,
                                   size_t size, char message[RF_DWA_MESSAGE_SIZE] );

#ifdef __cplusplus
}
#endif

#endif
