// The only source that includes OpenEXR's C++ library, which compresses files only: a block is a file of one tile in memory. No
// exception leaves it.
#include "image/dwa.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfTileDescription.h>
#include <ImfTiledInputFile.h>
#include <ImfTiledOutputFile.h>
#include <ImfVersion.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

namespace
{

constexpr int s_tile_head = 5 * 4; // its place, its level, the number of its bytes

class Out : public Imf::OStream
{
  public:
    Out() : Imf::OStream( "block" ) {}

    void write( const char bytes[], int count ) override
    {
        std::size_t size = static_cast<std::size_t>( count ), end = m_at + size;
        if ( end > m_bytes.size() )
            m_bytes.resize( end );
        std::copy( bytes, bytes + size, m_bytes.begin() + static_cast<std::ptrdiff_t>( m_at ) );
        m_at = end;
    }

    std::uint64_t tellp() override { return m_at; }

    void seekp( std::uint64_t at ) override
    {
        m_first_seek = m_first_seek == 0 ? at : m_first_seek;
        m_at = static_cast<std::size_t>( at );
    }

    std::string& bytes() { return m_bytes; }

    // Where the library first went back to: the table with the place of the tile.
    std::size_t table() const { return static_cast<std::size_t>( m_first_seek ); }

  private:
    std::string m_bytes; // not a vector, whose functions the shared library would show
    std::size_t m_at = 0;
    std::uint64_t m_first_seek = 0;
};

class In : public Imf::IStream
{
  public:
    explicit In( const std::string& bytes ) : Imf::IStream( "block" ), m_bytes( bytes ) {}

    bool read( char out[], int count ) override
    {
        std::size_t size = static_cast<std::size_t>( count );
        if ( m_at > m_bytes.size() || size > m_bytes.size() - m_at )
            throw std::runtime_error( "the block ends too early" );
        std::memcpy( out, m_bytes.data() + m_at, size );
        m_at += size;
        return m_at < m_bytes.size();
    }

    std::uint64_t tellg() override { return m_at; }
    void seekg( std::uint64_t at ) override { m_at = static_cast<std::size_t>( at ); }

  private:
    const std::string& m_bytes;
    std::size_t m_at = 0;
};

std::size_t bytes_of( const RfDwaChannel& channel ) { return channel.type == Imf::HALF ? 2 : 4; }

// The library compresses channels by the ends of their names, and writes which it has taken for colours into the block, for the
// reader: a name with another end is kept bit by bit. It stays at the same place among the others.
std::string name_of( const RfDwaChannel& channel ) { return std::string( channel.name ) + ( channel.exact != 0 ? "\1" : "" ); }

Imf::Header header_of( const RfDwaBlock& block )
{
    Imf::Header header( block.width, block.height, 1.0f, Imath::V2f( 0.0f, 0.0f ), 1.0f, Imf::INCREASING_Y,
                        Imf::DWAA_COMPRESSION );
    for ( int c = 0; c < block.count; ++c )
    {
        const RfDwaChannel& channel = block.channels[c];
        header.channels().insert( name_of( channel ),
                                  Imf::Channel( static_cast<Imf::PixelType>( channel.type ), 1, 1, channel.linear != 0 ) );
    }
    header.setTileDescription(
        Imf::TileDescription( static_cast<unsigned>( block.width ), static_cast<unsigned>( block.height ) ) );
    return header;
}

Imf::FrameBuffer buffer_of( const RfDwaBlock& block, char* pixels )
{
    Imf::FrameBuffer buffer;
    std::size_t line = 0;
    for ( int c = 0; c < block.count; ++c )
        line += bytes_of( block.channels[c] ) * static_cast<std::size_t>( block.width );
    for ( int c = 0; c < block.count; ++c )
    {
        const RfDwaChannel& channel = block.channels[c];
        buffer.insert( name_of( channel ),
                       Imf::Slice( static_cast<Imf::PixelType>( channel.type ), pixels, bytes_of( channel ), line ) );
        pixels += bytes_of( channel ) * static_cast<std::size_t>( block.width );
    }
    return buffer;
}

template <typename Number> Number number_at( const std::string& bytes, std::size_t at )
{
    Number number;
    if ( at > bytes.size() || sizeof number > bytes.size() - at )
        throw std::runtime_error( "the library has written no block" );
    std::memcpy( &number, bytes.data() + at, sizeof number );
    return number;
}

template <typename Number> void put( Out& out, Number number )
{
    char bytes[sizeof number];
    std::memcpy( bytes, &number, sizeof number );
    out.write( bytes, sizeof number );
}

std::size_t compress( const RfDwaBlock& block, const void* packed, std::size_t size, void* out )
{
    Out stream;
    {
        Imf::Header header = header_of( block );
        header.dwaCompressionLevel() = block.level;
        Imf::TiledOutputFile file( stream, header, 0 );
        // the library only reads the pixels
        file.setFrameBuffer( buffer_of( block, const_cast<char*>( static_cast<const char*>( packed ) ) ) );
        file.writeTile( 0, 0 );
    }
    const std::string& bytes = stream.bytes();
    std::size_t tile = static_cast<std::size_t>( number_at<std::uint64_t>( bytes, stream.table() ) );
    std::int32_t count = number_at<std::int32_t>( bytes, tile + s_tile_head - 4 );
    if ( count < 0 || static_cast<std::size_t>( count ) > size ||
         tile + s_tile_head + static_cast<std::size_t>( count ) > bytes.size() )
        throw std::runtime_error( "the library has written no block" );
    std::memcpy( out, bytes.data() + tile + s_tile_head, static_cast<std::size_t>( count ) );
    return static_cast<std::size_t>( count );
}

void decompress( const RfDwaBlock& block, const void* compressed, std::size_t size, void* out )
{
    Out stream;
    put( stream, static_cast<std::int32_t>( Imf::MAGIC ) );
    put( stream, static_cast<std::int32_t>( Imf::EXR_VERSION | Imf::TILED_FLAG | Imf::LONG_NAMES_FLAG ) );
    header_of( block ).writeTo( stream, true );
    put( stream, stream.tellp() + 8 );
    for ( int i = 0; i < 4; ++i )
        put( stream, std::int32_t{ 0 } );
    put( stream, static_cast<std::int32_t>( size ) );
    stream.write( static_cast<const char*>( compressed ), static_cast<int>( size ) );
    In input( stream.bytes() );
    Imf::TiledInputFile file( input, 0 );
    file.setFrameBuffer( buffer_of( block, static_cast<char*>( out ) ) );
    file.readTile( 0, 0 );
}

template <typename Work> RfDwaResult guard( char message[RF_DWA_MESSAGE_SIZE], Work work )
{
    try
    {
        work();
        return RF_DWA_OK;
    }
    catch ( const std::bad_alloc& )
    {
        return RF_DWA_MEMORY;
    }
    catch ( const std::exception& exception )
    {
        std::snprintf( message, RF_DWA_MESSAGE_SIZE, "%s", exception.what() );
        return RF_DWA_BROKEN;
    }
}

} // namespace

extern "C" RfDwaResult rf_compress_dwa( const RfDwaBlock* block, const void* packed, size_t size, void* out, size_t* compressed,
                                        char message[RF_DWA_MESSAGE_SIZE] )
{
    return guard( message, [&] { *compressed = compress( *block, packed, size, out ); } );
}

extern "C" RfDwaResult rf_decompress_dwa( const RfDwaBlock* block, const void* compressed, size_t compressed_size, void* out,
                                          size_t size, char message[RF_DWA_MESSAGE_SIZE] )
{
    return guard( message,
                  [&]
                  {
                      std::memset( out, 0, size );
                      decompress( *block, compressed, compressed_size, out );
                  } );
}
