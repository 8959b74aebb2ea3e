"""All campaigns, one after the other, and at the end a line on each: ``make torture``."""

from tests.torture import damages, full_disks, kills

print("\n".join(campaign() for campaign in (kills.main, damages.main, full_disks.main)))
