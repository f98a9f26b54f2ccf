"""Motion with the modes of rigid contacts held: rates, forces, constraints. For event_driven and adaptive."""
