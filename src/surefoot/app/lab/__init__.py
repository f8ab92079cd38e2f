"""Pages in a browser: stances, cones, pushed robots, plans and logs that follow the mouse.

What a page shows is computed without a browser: a page takes changes and returns a `Drawing`. One thin
layer (session, canvas, server) speaks to viser, which is imported where a server starts.
"""
