"""The library: projects, their takes and their history in a database.

    library = open_library()                # SQLite in the user's data folder, or MOTIONLOOM_LIBRARY
    key = library.create("Morning scene")
    shelf = library.shelf(key)              # a `studio.takes.TakeStore`

`schema` says what is in it, `database` opens it and puts its complaints into words, `library` has the projects,
`shelf` the takes of one, `query` what a search field understands.
"""

from studio.library.database import LibraryError, default_url
from studio.library.library import Found, Library, Project, open_library
from studio.library.query import Query
from studio.library.shelf import Shelf

__all__ = ["Found", "Library", "LibraryError", "Project", "Query", "Shelf", "default_url", "open_library"]
