"""What the inputs of shaders get: constants, or outputs of nodes, and what is calculated of the two."""
from .blackbody import colour_of
from .channels import BLACK, Ref, WHITE, is_constant
from .shader_tree import value_of

CALCULATE = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": lambda a, b: a / b if b != 0.0 else 0.0,
    "MAXIMUM": max,
    "MINIMUM": min,
    "GREATER_THAN": lambda a, b: float(a > b),
    "LESS_THAN": lambda a, b: float(a < b),
}


class Values:
    """A shader tree, in which nodes are put that calculate; `warn(node, text)` tells what is lost."""

    def __init__(self, tree, warn):
        self.tree, self.nodes, self.warn = tree, tree.nodes, warn

    def ref(self, socket):
        return Ref(socket.node.name, list(socket.node.outputs).index(socket))

    def socket(self, ref):
        return self.nodes[ref.node].outputs[ref.output]

    def read(self, socket):
        """The value that an input has."""
        if not socket.is_linked or not socket.links[0].is_valid:
            return value_of(socket)
        source = socket.links[0].from_socket
        kind, colour = source.node.type, socket.type in ("RGBA", "VECTOR")
        if kind == "RGB":
            value = value_of(source)
            return value if colour else 0.2126 * value[0] + 0.7152 * value[1] + 0.0722 * value[2]
        if kind == "VALUE":
            value = value_of(source)
            return (value,) * 3 if colour else value
        if kind == "COMBXYZ" and not any(i.is_linked for i in source.node.inputs):
            value = tuple(i.default_value for i in source.node.inputs)
            return value if colour else sum(value) / 3.0
        if kind == "BLACKBODY" and colour and not source.node.inputs[0].is_linked:
            return colour_of(source.node.inputs[0].default_value)
        value = self.calculated(source.node) if kind == "MATH" else None
        if value is not None:
            return (value,) * 3 if colour else value
        return self.ref(source)

    def calculated(self, node):
        """What a Math node makes of constants; None if they are not, or by an operation that is not listed."""
        operation = CALCULATE.get(node.operation)
        values = [self.read(i) for i in node.inputs[:2]]
        if operation is None or not all(isinstance(v, float) for v in values):
            return None
        value = operation(*values)
        return min(max(value, 0.0), 1.0) if node.use_clamp else value

    def put(self, value, socket):
        if isinstance(value, Ref):
            self.tree.links.new(self.socket(value), socket)
        else:
            room = getattr(socket.default_value, "__len__", None)
            if room is None:
                socket.default_value = value if isinstance(value, (int, float)) else sum(value) / 3.0
            else:
                three = (value,) * 3 if isinstance(value, (int, float)) else tuple(value)
                socket.default_value = (three + (1.0,))[:room()]

    def vector(self, operation, *values):
        node = self.nodes.new("ShaderNodeVectorMath")
        node.operation = operation
        for value, socket in zip(values, node.inputs):
            self.put(value, socket)
        return self.ref(node.outputs[0])

    def number(self, operation, *values, clamp=False):
        node = self.nodes.new("ShaderNodeMath")
        node.operation, node.use_clamp = operation, clamp
        for value, socket in zip(values, node.inputs):
            self.put(value, socket)
        return self.ref(node.outputs[0])

    def times(self, a, b, colour=False):
        """The product; b is a number or a colour, a colour only where `colour` is true."""
        if is_constant(a) and is_constant(b):
            if not colour:
                return a * b
            a, b = ((v,) * 3 if isinstance(v, (int, float)) else v for v in (a, b))
            return tuple(x * y for x, y in zip(a, b))
        for one, other in ((a, b), (b, a)):
            if one == 1.0 or one == WHITE:
                return other
            if one == 0.0 or one == BLACK:
                return BLACK if colour else 0.0
        return self.vector("MULTIPLY", a, b) if colour else self.number("MULTIPLY", a, b)

    def plus(self, a, b, colour=False):
        if is_constant(a) and is_constant(b):
            return tuple(x + y for x, y in zip(a, b)) if colour else a + b
        for one, other in ((a, b), (b, a)):
            if one == 0.0 or one == BLACK:
                return other
        return self.vector("ADD", a, b) if colour else self.number("ADD", a, b)

    def rest(self, t):
        return 1.0 - t if is_constant(t) else self.number("SUBTRACT", 1.0, t)

    def blend(self, a, b, t, colour=False):
        """a for t = 0, b for t = 1; what one side leaves open is the other's."""
        if a is None or b is None or a == b:
            return b if a is None else a
        if t == 0.0:
            return a
        if t == 1.0:
            return b
        return self.plus(self.times(a, self.rest(t), colour), self.times(b, t, colour), colour)
