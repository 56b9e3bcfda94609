"""Everything that says where the beat is, and how one Timeline is run after it."""
