#include "support/draco_encode.h"

#include <draco/compression/encode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <cstdlib>
#include <cstring>

namespace
{

draco::GeometryAttribute::Type kind_of( char kind )
{
    switch ( kind )
    {
        case 'p': return draco::GeometryAttribute::POSITION;
        case 'n': return draco::GeometryAttribute::NORMAL;
        case 't': return draco::GeometryAttribute::TEX_COORD;
        case 'c': return draco::GeometryAttribute::COLOR;
        default: return draco::GeometryAttribute::GENERIC;
    }
}

draco::DataType type_of( int type )
{
    switch ( type )
    {
        case 5120: return draco::DT_INT8;
        case 5121: return draco::DT_UINT8;
        case 5122: return draco::DT_INT16;
        case 5123: return draco::DT_UINT16;
        case 5125: return draco::DT_UINT32;
        default: return draco::DT_FLOAT32;
    }
}

void add_attributes( const DracoInput* input, draco::PointCloud* cloud )
{
    for ( int i = 0; i < input->attribute_count; ++i )
    {
        const DracoAttribute& from = input->attributes[i];
        const draco::DataType type = type_of( from.type );
        const int stride = draco::DataTypeLength( type ) * from.components;
        draco::GeometryAttribute attribute;
        attribute.Init( kind_of( from.kind ), nullptr, (uint8_t)from.components, type, from.normalized, stride, 0 );
        const int id = cloud->AddAttribute( attribute, true, input->points );
        cloud->attribute( id )->set_unique_id( (uint32_t)i );
        for ( uint32_t v = 0; v < input->points; ++v )
            cloud->attribute( id )->SetAttributeValue( draco::AttributeValueIndex( v ),
                                                       static_cast<const uint8_t*>( from.values ) + (size_t)v * stride );
    }
}

template <class Encoder> void quantise( const DracoInput* input, Encoder* encoder )
{
    for ( int i = 0; i < input->attribute_count; ++i )
    {
        if ( input->attributes[i].bits > 0 )
            encoder->SetAttributeQuantization( i, input->attributes[i].bits );
    }
}

} // namespace

uint8_t* encode_draco( const DracoInput* input, size_t* size )
{
    draco::Mesh mesh;
    draco::EncoderBuffer buffer;
    mesh.set_num_points( input->points );
    for ( uint32_t i = 0; i < input->faces && !input->cloud; ++i )
    {
        draco::Mesh::Face face;
        for ( int c = 0; c < 3; ++c )
            face[c] = input->indices[3 * i + c];
        mesh.AddFace( face );
    }
    add_attributes( input, &mesh );
    draco::PointCloud* cloud = &mesh;
    draco::ExpertEncoder encoder = input->cloud ? draco::ExpertEncoder( *cloud ) : draco::ExpertEncoder( mesh );
    if ( !input->cloud )
        encoder.SetEncodingMethod( input->sequential ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING );
    quantise( input, &encoder );
    if ( !encoder.EncodeToBuffer( &buffer ).ok() )
        return nullptr;
    *size = buffer.size();
    uint8_t* bytes = static_cast<uint8_t*>( std::malloc( *size ) );
    std::memcpy( bytes, buffer.data(), *size );
    return bytes;
}
