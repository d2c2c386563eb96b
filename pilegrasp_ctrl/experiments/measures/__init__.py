"""What a study keeps of a recording: a package of its own, since a study is refused where its measure has changed."""
