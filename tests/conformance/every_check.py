"""Fills the list of checks (checks.REGISTRY): those of servers and those of clients."""
import checks_admin  # noqa: F401
import checks_client  # noqa: F401
import checks_client_faults  # noqa: F401
import checks_control  # noqa: F401
import checks_datagram  # noqa: F401
import checks_roles  # noqa: F401
import checks_robots  # noqa: F401
import checks_session  # noqa: F401
import checks_shapes  # noqa: F401
