// The only source that includes libdraco. No exception leaves it.
#include "gltf/draco_mesh.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <new>

struct RfDracoMesh
{
    draco::Mesh mesh;
};

namespace
{

struct Limits
{
    uint64_t faces, bytes;
    bool exceeded;
};

// glTF is written against 2.2; since 2.0 numbers are of variable length, which the limits rely on.
constexpr uint16_t s_oldest = DRACO_BITSTREAM_VERSION( 2, 0 );

// Compares the first two numbers, of which connectivity has the larger allocations.
bool accept( const draco::DecoderBuffer& buffer, bool edgebreaker, Limits* limits )
{
    draco::DecoderBuffer ahead( buffer );
    uint16_t version = buffer.bitstream_version();
    uint32_t first = 0, second = 0;
    bool read = version >= s_oldest;
    if ( edgebreaker && version < DRACO_BITSTREAM_VERSION( 2, 2 ) ) // of vertices that were split
        read = read && draco::DecodeVarint( &first, &ahead );
    if ( edgebreaker || version >= DRACO_BITSTREAM_VERSION( 2, 2 ) )
        read = read && draco::DecodeVarint( &first, &ahead ) && draco::DecodeVarint( &second, &ahead );
    else
        read = read && ahead.Decode( &first ) && ahead.Decode( &second );
    uint64_t faces = edgebreaker ? second : first, points = edgebreaker ? first : second;
    limits->exceeded = read && ( faces > limits->faces || points > 3 * limits->faces );
    return read && !limits->exceeded;
}

// Each value is there as it is stored and as integers on the way to it.
bool accept( const draco::PointCloud& cloud, Limits* limits )
{
    uint64_t room = limits->bytes;
    for ( int i = 0; i < cloud.num_attributes() && !limits->exceeded; ++i )
    {
        const draco::PointAttribute* attribute = cloud.attribute( i );
        uint64_t size = static_cast<uint64_t>( draco::DataTypeLength( attribute->data_type() ) ) + 4;
        uint64_t need = size * static_cast<uint64_t>( attribute->num_components() ) * cloud.num_points();
        limits->exceeded = need > room;
        room -= limits->exceeded ? 0 : need;
    }
    return !limits->exceeded;
}

template <class Decoder, bool edgebreaker> class Limited final : public Decoder
{
  public:
    explicit Limited( Limits* limits ) : m_limits( limits ) {}

  protected:
    bool DecodeConnectivity() override
    {
        return accept( *this->buffer(), edgebreaker, m_limits ) && Decoder::DecodeConnectivity();
    }

    bool DecodeAllAttributes() override { return accept( *this->point_cloud(), m_limits ) && Decoder::DecodeAllAttributes(); }

  private:
    Limits* m_limits;
};

template <class Decoder> bool run( Decoder decoder, draco::DecoderBuffer* buffer, draco::Mesh* mesh )
{
    draco::DecoderOptions options;
    return decoder.Decode( options, buffer, mesh ).ok();
}

// Every point must have a value in the buffer of the attribute.
bool is_whole( const draco::PointAttribute& attribute, uint32_t points )
{
    if ( attribute.buffer() == nullptr || ( !attribute.is_mapping_identity() && attribute.indices_map_size() < points ) )
        return false;
    const uint64_t size = attribute.buffer()->data_size(), offset = static_cast<uint64_t>( attribute.byte_offset() );
    const uint64_t stride = static_cast<uint64_t>( attribute.byte_stride() );
    const uint64_t length = static_cast<uint64_t>( draco::DataTypeLength( attribute.data_type() ) ) * attribute.num_components();
    for ( uint32_t i = 0; i < points; ++i )
    {
        const uint64_t value = attribute.mapped_index( draco::PointIndex( i ) ).value();
        if ( value >= attribute.size() || offset + stride * value + length > size )
            return false;
    }
    return true;
}

bool is_whole( const draco::Mesh& mesh )
{
    for ( int i = 0; i < mesh.num_attributes(); ++i )
    {
        if ( !is_whole( *mesh.attribute( i ), mesh.num_points() ) )
            return false;
    }
    return true;
}

RfDracoResult decode( const uint8_t* bytes, size_t size, Limits* limits, RfDracoMesh** out )
{
    draco::DecoderBuffer buffer;
    buffer.Init( reinterpret_cast<const char*>( bytes ), size );
    draco::DecoderBuffer ahead( buffer );
    draco::DracoHeader header;
    if ( !draco::PointCloudDecoder::DecodeHeader( &ahead, &header ).ok() )
        return RF_DRACO_BROKEN;
    if ( header.encoder_type == draco::POINT_CLOUD )
        return RF_DRACO_NO_MESH;
    std::unique_ptr<RfDracoMesh> mesh( new RfDracoMesh );
    bool decoded = false;
    if ( header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING )
        decoded = run( Limited<draco::MeshEdgebreakerDecoder, true>( limits ), &buffer, &mesh->mesh );
    else if ( header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING )
        decoded = run( Limited<draco::MeshSequentialDecoder, false>( limits ), &buffer, &mesh->mesh );
    if ( !decoded || !is_whole( mesh->mesh ) )
        return limits->exceeded ? RF_DRACO_TOO_LARGE : RF_DRACO_BROKEN;
    *out = mesh.release();
    return RF_DRACO_OK;
}

template <class T> double read( const uint8_t* at )
{
    T value;
    std::memcpy( &value, at, sizeof value );
    return static_cast<double>( value );
}

double read_component( const uint8_t* at, draco::DataType type )
{
    switch ( type )
    {
        case draco::DT_INT8: return read<int8_t>( at );
        case draco::DT_BOOL:
        case draco::DT_UINT8: return read<uint8_t>( at );
        case draco::DT_INT16: return read<int16_t>( at );
        case draco::DT_UINT16: return read<uint16_t>( at );
        case draco::DT_INT32: return read<int32_t>( at );
        case draco::DT_UINT32: return read<uint32_t>( at );
        case draco::DT_INT64: return read<int64_t>( at );
        case draco::DT_UINT64: return read<uint64_t>( at );
        case draco::DT_FLOAT32: return read<float>( at );
        case draco::DT_FLOAT64: return read<double>( at );
        default: return std::numeric_limits<double>::quiet_NaN();
    }
}

// What a normalised integer of 1 is.
double unit( draco::DataType type )
{
    switch ( type )
    {
        case draco::DT_INT8: return 127.0;
        case draco::DT_UINT8: return 255.0;
        case draco::DT_INT16: return 32767.0;
        case draco::DT_UINT16: return 65535.0;
        default: return 1.0;
    }
}

template <class T> bool write( double value, uint8_t* at )
{
    if ( !( value >= std::numeric_limits<T>::lowest() && value <= std::numeric_limits<T>::max() ) )
        return false;
    const T typed = static_cast<T>( value );
    std::memcpy( at, &typed, sizeof typed );
    return std::numeric_limits<T>::is_integer ? static_cast<double>( typed ) == value : true;
}

bool write_component( double value, int component_type, uint8_t* at )
{
    switch ( component_type )
    {
        case 5120: return write<int8_t>( value, at );
        case 5121: return write<uint8_t>( value, at );
        case 5122: return write<int16_t>( value, at );
        case 5123: return write<uint16_t>( value, at );
        case 5125: return write<uint32_t>( value, at );
        default: return write<float>( value, at );
    }
}

size_t component_size( int component_type ) { return component_type <= 5121 ? 1 : component_type <= 5123 ? 2 : 4; }

} // namespace

RfDracoResult rf_draco_decode( const uint8_t* bytes, size_t size, uint64_t most_faces, uint64_t most_bytes, RfDracoMesh** mesh )
{
    Limits limits = { most_faces, most_bytes, false };
    *mesh = nullptr;
    try
    {
        return decode( bytes, size, &limits, mesh );
    }
    catch ( const std::bad_alloc& )
    {
        return RF_DRACO_MEMORY;
    }
    catch ( ... ) // such as a vector of impossible length
    {
        return RF_DRACO_BROKEN;
    }
}

void rf_draco_free( RfDracoMesh* mesh ) { delete mesh; }

uint32_t rf_draco_faces( const RfDracoMesh* mesh ) { return mesh->mesh.num_faces(); }

uint32_t rf_draco_points( const RfDracoMesh* mesh ) { return mesh->mesh.num_points(); }

uint64_t rf_draco_bytes( const RfDracoMesh* mesh )
{
    uint64_t bytes = sizeof( draco::Mesh::Face ) * static_cast<uint64_t>( mesh->mesh.num_faces() );
    for ( int i = 0; i < mesh->mesh.num_attributes(); ++i )
    {
        const draco::PointAttribute& attribute = *mesh->mesh.attribute( i );
        bytes += attribute.buffer()->data_size() + sizeof( draco::AttributeValueIndex ) * attribute.indices_map_size();
    }
    return bytes;
}

int rf_draco_attributes( const RfDracoMesh* mesh ) { return mesh->mesh.num_attributes(); }

int rf_draco_find( const RfDracoMesh* mesh, uint32_t unique_id ) { return mesh->mesh.GetAttributeIdByUniqueId( unique_id ); }

int rf_draco_components( const RfDracoMesh* mesh, int attribute ) { return mesh->mesh.attribute( attribute )->num_components(); }

void rf_draco_copy_indices( const RfDracoMesh* mesh, uint32_t* indices )
{
    for ( uint32_t i = 0; i < mesh->mesh.num_faces(); ++i )
    {
        const draco::Mesh::Face& face = mesh->mesh.face( draco::FaceIndex( i ) );
        for ( int c = 0; c < 3; ++c )
            *indices++ = face[c].value();
    }
}

bool rf_draco_copy( const RfDracoMesh* mesh, int attribute, int component_type, uint8_t* values )
{
    const draco::PointAttribute& from = *mesh->mesh.attribute( attribute );
    const size_t from_size = static_cast<size_t>( draco::DataTypeLength( from.data_type() ) );
    const size_t size = component_size( component_type );
    const double one = component_type == 5126 && from.normalized() ? unit( from.data_type() ) : 1.0;
    for ( uint32_t i = 0; i < mesh->mesh.num_points(); ++i )
    {
        const uint8_t* at = from.GetAddress( from.mapped_index( draco::PointIndex( i ) ) );
        for ( int c = 0; c < from.num_components(); ++c, at += from_size, values += size )
        {
            if ( !write_component( read_component( at, from.data_type() ) / one, component_type, values ) )
                return false;
        }
    }
    return true;
}
