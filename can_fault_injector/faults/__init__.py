"""The fault vocabulary: what triggers a fault, what it does to the bus, how long; files, and the engine that runs them.

The models of the files (`levels`, `trigger`, `bit_level`, `frame_level`, `signal_level`, `node_level`, `wire_level`,
`fault_file`, `vocabulary`) import no compiled code; the engine does.
"""
