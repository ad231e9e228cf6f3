#include "support/openexr_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfTileDescription.h>
#include <ImfTiledOutputFile.h>

#include <cstddef>
#include <cstdio>
#include <exception>
#include <half.h>
#include <vector>

namespace
{

constexpr int s_tile = 48; // higher than a chunk of lines of DWAA

Imf::FrameBuffer pixels_of( const float* values, int width, int height, std::vector<half>& halves )
{
    std::size_t count = 3 * static_cast<std::size_t>( width ) * static_cast<std::size_t>( height );
    halves.assign( values, values + count );
    Imf::FrameBuffer buffer;
    const char* const names[] = { "R", "G", "B" };
    std::size_t line = 3 * static_cast<std::size_t>( width );
    for ( int c = 0; c < 3; ++c )
        buffer.insert( names[c], Imf::Slice( Imf::HALF, reinterpret_cast<char*>( halves.data() + c ), 6, 2 * line ) );
    buffer.insert( "Z", Imf::Slice( Imf::FLOAT, reinterpret_cast<char*>( const_cast<float*>( values ) ), 12, 4 * line ) );
    return buffer;
}

} // namespace

extern "C" bool read_by_openexr( const char* path, const char* channel, int width, int height, float* values )
{
    try
    {
        Imf::MultiPartInputFile file( path );
        for ( int p = 0; p < file.parts(); ++p )
        {
            const Imf::Header& header = file.header( p );
            if ( header.channels().findChannel( channel ) == nullptr )
                continue;
            const Imath::Box2i window = header.dataWindow();
            if ( window.max.x - window.min.x + 1 != width || window.max.y - window.min.y + 1 != height )
                return false;
            std::size_t line = sizeof( float ) * static_cast<std::size_t>( width );
            char* origin = reinterpret_cast<char*>( values ) - static_cast<std::ptrdiff_t>( sizeof( float ) ) * window.min.x -
                           static_cast<std::ptrdiff_t>( line ) * window.min.y;
            Imf::FrameBuffer buffer;
            buffer.insert( channel, Imf::Slice( Imf::FLOAT, origin, sizeof( float ), line ) );
            Imf::InputPart part( file, p );
            part.setFrameBuffer( buffer );
            part.readPixels( window.min.y, window.max.y );
            return true;
        }
        std::fprintf( stderr, "%s: no channel %s\n", path, channel );
    }
    catch ( const std::exception& exception )
    {
        std::fprintf( stderr, "%s\n", exception.what() );
    }
    return false;
}

extern "C" bool write_by_openexr( const char* path, int width, int height, const float* values, bool tiled, bool dwab )
{
    try
    {
        Imf::Header header( width, height );
        header.compression() = dwab ? Imf::DWAB_COMPRESSION : Imf::DWAA_COMPRESSION;
        for ( const char* name : { "R", "G", "B" } )
            header.channels().insert( name, Imf::Channel( Imf::HALF ) );
        header.channels().insert( "Z", Imf::Channel( Imf::FLOAT ) );
        std::vector<half> halves;
        Imf::FrameBuffer buffer = pixels_of( values, width, height, halves );
        if ( tiled )
        {
            header.setTileDescription( Imf::TileDescription( s_tile, s_tile ) );
            Imf::TiledOutputFile file( path, header );
            file.setFrameBuffer( buffer );
            file.writeTiles( 0, file.numXTiles() - 1, 0, file.numYTiles() - 1 );
            return true;
        }
        Imf::OutputFile file( path, header );
        file.setFrameBuffer( buffer );
        file.writePixels( height );
        return true;
    }
    catch ( const std::exception& exception )
    {
        std::fprintf( stderr, "%s\n", exception.what() );
        return false;
    }
}
