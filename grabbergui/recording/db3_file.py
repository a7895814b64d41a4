"""SQLite files of rosbag2 (`.db3`), the default storage of ROS 2 up to Humble.

Tables `topics` (id, name, type, serialization_format, …) and `messages` (id, topic_id, timestamp, data), as
rosbag2_storage_sqlite3 creates them. The database may come from a stranger: it is opened read-only, its
schema is not trusted with functions, and a time limit ends any query, as a view can compute for ever.
"""

from __future__ import annotations

import sqlite3
import time
from pathlib import Path
from typing import Any
from urllib.parse import quote

from typing_extensions import override

from grabbergui.core.errors import UsageError
from grabbergui.core.regular_files import check_regular
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.message_store import WANTED_TYPES, MessageStore, Place, TopicChannel

_MAGIC = "SQLite format 3"
MAX_MESSAGE = 1 << 28
"Bytes of the largest message."
MOST_TOPICS = 10_000
QUERY_TIME = 60.0
"Most seconds of the index's query, which reads the whole file where the system has not cached it."
READ_TIME = 2.0
"Most seconds of reading one message."
_STEPS = 10_000
"SQLite's instructions between checks of the time."


class Db3File(MessageStore):
    """A rosbag2 database and the index of its messages."""

    def __init__(self, path: Path, number: int = 0) -> None:
        """Open and index a file. Raises UsageError, RecordingError, OSError."""
        self.path, self.number = path, number
        self.channels, self.messages = {}, []
        self._until = 0.0
        check_regular(path)
        try:
            # Immutable: no lock, and no journal beside it that could change what is read.
            self._database = sqlite3.connect(
                f"file:{quote(str(path.absolute()))}?mode=ro&immutable=1", uri=True, check_same_thread=False
            )
        except sqlite3.Error as error:
            raise self._unreadable(error) from error
        try:
            self._database.text_factory = lambda content: str(content, "utf-8", "replace")
            self._database.execute("PRAGMA trusted_schema = OFF")
            self._database.set_progress_handler(self._late, _STEPS)
            if hasattr(self._database, "setlimit"):  # Python 3.11
                self._database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_MESSAGE)
            self._index()
        except (sqlite3.Error, UnicodeDecodeError) as error:  # a damaged text, perhaps within a message
            self._database.close()
            raise self._unreadable(error) from error
        except BaseException:
            self._database.close()
            raise

    @override
    def content(self, place: Place) -> bytes:
        try:
            rows = self._rows("SELECT data FROM messages WHERE id = ?", READ_TIME, place.offset)
            (data,) = next(iter(rows), (b"",))
        except (sqlite3.Error, ValueError) as error:
            raise RecordingError(f"{self.path}: a message cannot be read: {error}") from error
        return data if isinstance(data, bytes) else b""

    @override
    def close(self) -> None:
        self._database.close()

    def _index(self) -> None:
        for name in ("topics", "messages"):
            query = f"SELECT type, sql FROM sqlite_master WHERE name = '{name}'"
            match next(iter(self._rows(query, READ_TIME)), None):
                case ("table", str(sql)) if sql.upper().startswith("CREATE TABLE"):
                    pass
                case _:  # a view could have any number of rows, and a virtual table any code
                    raise UsageError(f"{self.path} is no database of rosbag2: it has no table '{name}'")
        topics = "SELECT id, name, type, serialization_format FROM topics"
        for row in self._rows(f"{topics} LIMIT {MOST_TOPICS}", QUERY_TIME):
            match row:
                case (int(number), str(name), str(kind), str(encoding)):
                    self.channels[number] = TopicChannel(name, kind, encoding)
        wanted = [str(number) for number, each in self.channels.items() if each.type in WANTED_TYPES]
        columns = "SELECT id, topic_id, timestamp, length(data) FROM messages"
        query = f"{columns} WHERE topic_id IN ({','.join(wanted)})"
        counts: dict[int, int] = {}
        for row in self._rows(f"{query} ORDER BY timestamp, id", QUERY_TIME):
            match row:
                case (int(number), int(topic), int(timestamp), int(length)) if length <= MAX_MESSAGE:
                    counts[topic] = sequence = counts.get(topic, -1) + 1
                    self.add(Place(self.number, -1, number, length, topic, sequence, max(0, timestamp)))

    def _rows(self, query: str, seconds: float, *values: int) -> Any:
        self._until = time.monotonic() + seconds
        return self._database.execute(query, values)

    def _late(self) -> bool:
        """Return whether the query has taken too long, which ends it."""
        return time.monotonic() > self._until

    def _unreadable(self, error: Exception) -> UsageError:
        if isinstance(error, sqlite3.OperationalError) and "interrupted" in str(error):
            return UsageError(f"{self.path}: its index takes longer than {QUERY_TIME:g} s; it is not read")
        return UsageError(f"{self.path} is no database of rosbag2: {error}")
