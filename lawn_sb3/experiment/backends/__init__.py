"""Who does the work: ``job`` says what work is and how it is told about.

``local`` does it on this machine, ``ray_cluster`` on those of a Ray cluster; ``choice`` finds either by its name.
"""
